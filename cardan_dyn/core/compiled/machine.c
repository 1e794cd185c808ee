/* Tapes run on blocks of lanes: one program, or several as stages that hand on their results.

   A program is a prologue, which runs once in a call, its constants, and its code, which runs for
   each block; both work on the same registers. It is checked and copied when it is made, and calls
   check their arrays, so that no instruction reads or writes what is not the call's. The last block
   of the arrays lies over lanes of the one before it, but only writes its own. */

#include "kernels.h"

#ifdef HAS_MACHINE

#ifdef __x86_64__
#include <immintrin.h>
#endif

/* Sines and cosines: an angle is taken apart into k pi/2 and a rest. Products of k with the first
   two parts of pi/2, of 33 bits each, are exact as long as k has at most 20 bits. The third part
   lacks less than 1e-37; with the k of FARTHEST that is half a unit in the last place of the least
   rest there is, 1e-16. */
#define QUARTER_1 0x1.921fb544p+0
#define QUARTER_2 0x1.0b4611a6p-34
#define QUARTER_3 0x1.3198a2e037073p-69
#define QUARTERS 0x1.45f306dc9c883p-1 /* of a circle in 1 rad */
#define FARTHEST (0x1p16 * QUARTER_1)
/* Added to a number, it leaves no bits behind the point. */
#define UNITS 0x1.8p+52
/* 1 / n! */
#define INVERSE_3 (1.0 / 6)
#define INVERSE_4 (1.0 / 24)
#define INVERSE_5 (1.0 / 120)
#define INVERSE_6 (1.0 / 720)
#define INVERSE_7 (1.0 / 5040)
#define INVERSE_8 (1.0 / 40320)
#define INVERSE_9 (1.0 / 362880)
#define INVERSE_10 (1.0 / 3628800)
#define INVERSE_11 (1.0 / 39916800)
#define INVERSE_12 (1.0 / 479001600)
#define INVERSE_13 (1.0 / 6227020800)
#define INVERSE_14 (1.0 / 87178291200)
#define INVERSE_15 (1.0 / 1307674368000)
#define INVERSE_16 (1.0 / 20922789888000)
#define INVERSE_17 (1.0 / 355687428096000)

/* Outputs of so many bytes are more than the caches keep, and pass by them. */
#define STREAMED (16 << 20)

#define WIDTH 2
#define TARGET
#ifdef __x86_64__
#define STREAM(to, vector) _mm_stream_pd(to, (__m128d)(vector))
#else
#define STREAM(to, vector) *(Numbers *)(to) = (vector)
#endif
#define LANES 4
#define NAMED(name) name##_4
#include "machine_lanes.h"
#define LANES 32
#define NAMED(name) name##_32
#include "machine_lanes.h"
#undef WIDTH
#undef TARGET
#undef STREAM

#ifdef __x86_64__
#define WIDTH 4
#define TARGET __attribute__((target("avx2")))
#define STREAM(to, vector) _mm256_stream_pd(to, (__m256d)(vector))
#define LANES 4
#define NAMED(name) name##_4_avx2
#include "machine_lanes.h"
#define LANES 32
#define NAMED(name) name##_32_avx2
#include "machine_lanes.h"
#undef WIDTH
#undef TARGET
#undef STREAM
#endif

/* Registers start with a line of the cache, in bytes. */
#define ALIGNED 64

static const char PROGRAM[] = "cardan_dyn.program";

typedef struct {
    int lanes; /* of a block */
    Py_ssize_t registers, inputs, rows;
    const int32_t *prologue, *code;
    const double *constants;
    const char *uniform; /* for each input whether it has to be one number for all lanes */
} Program;

typedef struct {
    const Program *program;
    /* Where each input is; which row of the own last pass, and of the stage before, it is instead,
       -1 if none. NULL: none at all. */
    Input *given;
    const int32_t *carried, *taken;
    /* Passes: until a row is within a bound in all lanes (-1: no row is asked), at most so many. */
    Py_ssize_t until, most;
    double within;
    /* Results, or NULL: how many passes each block took, and outputs, with rows so far apart. */
    int32_t *passes;
    double *outputs;
    Py_ssize_t apart;
    int streaming;
    /* Work space: registers, inputs of a pass, outputs of a block by this pass and the last. */
    double *registers;
    Input *input;
    double *results, *earlier;
} Stage;

typedef struct {
    const Machine *machine;
    Py_ssize_t lanes; /* of the arrays */
    Stage *stages;
    Py_ssize_t count;
    Taken *held;
    void *room;
} Call;

/* ------------------------------------------------------------------------------- running */

/* Whether a row of the outputs is within the bound in all lanes; NaN is not. */
static int is_done(const Stage *stage, int lanes)
{
    if (stage->until < 0)
        return 0;
    const double *row = stage->results + stage->until * lanes;
    int done = 1;
    for (int l = 0; l < lanes; l++)
        done &= row[l] <= stage->within;
    return done;
}

/* Run a stage on the block that begins at a lane, on rows of the stage before. */
static Py_ssize_t run_passes(const Machine *machine, Stage *stage, const double *before,
                             Py_ssize_t block)
{
    const Program *program = stage->program;
    for (Py_ssize_t k = 0; k < program->inputs; k++)
        if (stage->taken && stage->taken[k] >= 0)
            stage->input[k] = (Input){before + stage->taken[k] * machine->lanes, 0};
        else
            stage->input[k] = stage->given[k];
    for (Py_ssize_t passes = 1;; passes++) {
        machine->run(program->code, program->constants, (char *)stage->registers, stage->input,
                     stage->results, block);
        if (passes >= stage->most || is_done(stage, machine->lanes))
            return passes;
        for (Py_ssize_t k = 0; stage->carried && k < program->inputs; k++)
            if (stage->carried[k] >= 0)
                stage->input[k] =
                    (Input){stage->results + stage->carried[k] * machine->lanes, 0};
        double *results = stage->results;
        stage->results = stage->earlier;
        stage->earlier = results;
    }
}

static void run_call(const Call *call)
{
    const Machine *machine = call->machine;
    for (Py_ssize_t s = 0; s < call->count; s++) {
        const Stage *stage = &call->stages[s];
        machine->run(stage->program->prologue, stage->program->constants, (char *)stage->registers,
                     stage->given, NULL, 0);
    }
    for (Py_ssize_t from = 0; from < call->lanes; from += machine->lanes) {
        const Py_ssize_t end = from + machine->lanes;
        const Py_ssize_t block = end <= call->lanes ? from : call->lanes - machine->lanes;
        const double *before = NULL;
        for (Py_ssize_t s = 0; s < call->count; s++) {
            Stage *stage = &call->stages[s];
            Py_ssize_t passes = run_passes(machine, stage, before, block);
            before = stage->results;
            if (stage->passes)
                stage->passes[from / machine->lanes] = (int32_t)passes;
            if (stage->outputs)
                machine->write(stage->outputs + block, stage->apart, stage->results,
                               stage->program->rows, (int)(from - block), stage->streaming);
        }
    }
#ifdef __x86_64__
    /* What passed by the caches is seen by whoever is told that the call is over. */
    _mm_sfence();
#endif
}

/* ------------------------------------------------------------------------------ arrays */

/* From here on, functions return NULL or -1 with an error set. */

static void release_call(Call *call)
{
    release(&call->held);
    for (Py_ssize_t s = 0; call->stages && s < call->count; s++)
        free(call->stages[s].given);
    free(call->stages);
    free(call->room);
}

/* Take an integer within bounds. */
static int take_count(PyObject *object, Py_ssize_t least, Py_ssize_t most, Py_ssize_t *count)
{
    *count = PyLong_AsSsize_t(object);
    if (*count == -1 && PyErr_Occurred())
        return -1;
    if (*count < least || *count > most) {
        PyErr_Format(PyExc_ValueError, "%zd is not between %zd and %zd", *count, least, most);
        return -1;
    }
    return 0;
}

/* Take an array for outputs, of which numbers of a row lie side by side. */
static const Py_buffer *take_outputs(Call *call, Stage *stage, PyObject *object)
{
    const Py_buffer *buffer = take(&call->held, object, 'd', PyBUF_STRIDES | PyBUF_WRITABLE);
    if (!buffer)
        return NULL;
    if (buffer->ndim != 2 || buffer->shape[0] != stage->program->rows ||
        (buffer->shape[1] > 1 && buffer->strides[1] != 8) || buffer->strides[0] % 8) {
        PyErr_Format(PyExc_ValueError, "outputs have %zd rows, of numbers side by side",
                     stage->program->rows);
        return NULL;
    }
    stage->outputs = buffer->buf;
    stage->apart = buffer->strides[0] / 8;
    stage->streaming = buffer->len >= STREAMED;
    return buffer;
}

/* ---------------------------------------------------------------------------- programs */

static void free_program(PyObject *capsule)
{
    free(PyCapsule_GetPointer(capsule, PROGRAM));
}

/* Whether each operand of an instruction is one that there is. Registers become offsets in bytes.
   Marks inputs that have to be one number. */
static int is_instruction(const Program *program, int32_t *row, int is_prologue,
                          Py_ssize_t constant_count, char *uniform)
{
#define OPERANDS(name, operands) operands,
    static const char *const operands[] = {EVERY_OPERATION(OPERANDS)};
#undef OPERANDS
    if (row[0] < 0 || row[0] >= (int32_t)(sizeof(operands) / sizeof(*operands)))
        return 0;
    for (const char *kind = operands[*row++]; *kind; kind++, row++) {
        const int is_register = strchr("dms", *kind) != NULL;
        const Py_ssize_t end = is_register     ? program->registers
                               : *kind == 'k' ? constant_count
                               : *kind == 'r' ? program->rows
                                              : program->inputs;
        if (*kind == 'm' && *row == -1)
            continue;
        if (*row < 0 || *row >= end || (is_prologue && strchr("ir", *kind)))
            return 0;
        if (*kind == 'u')
            uniform[*row] = 1;
        if (is_register)
            *row *= 8 * program->lanes;
    }
    return 1;
}

/* Check that a tape ends, and all its instructions. */
static int check_tape(const Program *program, int32_t *tape, Py_ssize_t rows,
                      Py_ssize_t constant_count, char *uniform)
{
    const int is_prologue = tape == program->prologue;
    const char *name = is_prologue ? "prologue" : "code";
    if (!rows || tape[ROW * (rows - 1)] != 0) {
        PyErr_Format(PyExc_ValueError, "the %s of a program does not end", name);
        return -1;
    }
    for (Py_ssize_t k = 0; k < rows; k++)
        if (!is_instruction(program, tape + ROW * k, is_prologue, constant_count, uniform)) {
            PyErr_Format(PyExc_ValueError, "instruction %zd in the %s of a program does not fit", k,
                         name);
            return -1;
        }
    return 0;
}

static const Py_buffer *take_tape(Call *call, PyObject *object)
{
    const Py_buffer *buffer = take(&call->held, object, 'i', PyBUF_C_CONTIGUOUS);
    if (buffer && (buffer->ndim != 2 || buffer->shape[1] != ROW)) {
        PyErr_Format(PyExc_ValueError, "instructions are rows of %d integers", ROW);
        return NULL;
    }
    return buffer;
}

/* Copy a program's arrays behind it, and check what they say. */
static Program *copied_program(const Program *sizes, const Py_buffer *prologue,
                               const Py_buffer *constants, const Py_buffer *code)
{
    Program *made = calloc(1, sizeof(Program) + constants->len + prologue->len + code->len +
                                  sizes->inputs);
    if (!made) {
        PyErr_NoMemory();
        return NULL;
    }
    *made = *sizes;
    char *at = (char *)(made + 1);
    made->constants = memcpy(at, constants->buf, constants->len);
    int32_t *first = memcpy(at += constants->len, prologue->buf, prologue->len);
    int32_t *each = memcpy(at += prologue->len, code->buf, code->len);
    made->prologue = first;
    made->code = each;
    made->uniform = at += code->len;
    Py_ssize_t count = constants->len / 8;
    if (check_tape(made, first, prologue->shape[0], count, at) < 0 ||
        check_tape(made, each, code->shape[0], count, at) < 0) {
        free(made);
        return NULL;
    }
    return made;
}

/* program(prologue, constants, code, registers, inputs, outputs, block)

   Returns a handle of a program for blocks of 4 or 32 lanes, with so many registers, inputs and
   outputs. `prologue` and `code` are instructions (n, 8), with numbers of registers. */
PyObject *program(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 7)
    Py_ssize_t lanes;
    Program sizes = {0};
    if (take_count(given[6], 4, 32, &lanes) < 0)
        return NULL;
    if (lanes != 4 && lanes != 32) {
        PyErr_Format(PyExc_ValueError, "blocks have 4 lanes or 32, not %zd", lanes);
        return NULL;
    }
    sizes.lanes = (int)lanes;
    /* 32 bits tell where registers are. */
    const Py_ssize_t most = INT32_MAX / (8 * lanes);
    if (take_count(given[3], 0, most, &sizes.registers) < 0 ||
        take_count(given[4], 0, most, &sizes.inputs) < 0 ||
        take_count(given[5], 0, most, &sizes.rows) < 0)
        return NULL;
    Call call = {0};
    const Py_buffer *prologue = take_tape(&call, given[0]);
    const Py_buffer *constants =
        prologue ? take(&call.held, given[1], 'd', PyBUF_C_CONTIGUOUS) : NULL;
    const Py_buffer *code = constants ? take_tape(&call, given[2]) : NULL;
    Program *made = code ? copied_program(&sizes, prologue, constants, code) : NULL;
    release_call(&call);
    PyObject *capsule = made ? PyCapsule_New(made, PROGRAM, free_program) : NULL;
    if (!capsule)
        free(made);
    return capsule;
}

/* ------------------------------------------------------------------------------- calls */

/* The machine for blocks of so many lanes. CARDAN_DYN_AVX2=0 in the environment does without these
   instructions. */
static const Machine *machine_for(int lanes)
{
#ifdef __x86_64__
    const char *wanted = getenv("CARDAN_DYN_AVX2");
    if (__builtin_cpu_supports("avx2") && !(wanted && strcmp(wanted, "0") == 0))
        return lanes == 4 ? &machine_4_avx2 : &machine_32_avx2;
#endif
    return lanes == 4 ? &machine_4 : &machine_32;
}

/* Take the program of a stage, and the machine for it. */
static int take_program(Call *call, Stage *stage, PyObject *handle)
{
    stage->program = PyCapsule_GetPointer(handle, PROGRAM);
    if (!stage->program)
        return -1;
    call->machine = machine_for(stage->program->lanes);
    return 0;
}

/* Check that there are lanes enough. */
static int check_lanes(const Call *call)
{
    const int block = call->machine->lanes;
    if (call->lanes < block) {
        PyErr_Format(PyExc_ValueError, "%zd lanes are fewer than a block of %d", call->lanes,
                     block);
        return -1;
    }
    return 0;
}

/* Take an input that is rows of an array, or None where it is a row of the stage before. Returns how
   many inputs these are, from the k-th on; -1 if they do not fit. */
static Py_ssize_t take_input(Call *call, Stage *stage, PyObject *input, Py_ssize_t k)
{
    const Py_ssize_t left = stage->program->inputs - k;
    Py_ssize_t rows = 1, size = 0, apart = 0;
    const double *at = NULL;
    if (input != Py_None || !stage->taken || k >= stage->program->inputs || stage->taken[k] < 0) {
        const Py_buffer *buffer = take(&call->held, input, 'd', PyBUF_STRIDES);
        if (!buffer)
            return -1;
        const int last = buffer->ndim - 1;
        at = buffer->buf;
        size = last < 0 ? 1 : buffer->shape[last];
        if (last == 1) {
            rows = buffer->shape[0];
            apart = buffer->strides[0] / 8;
        }
        if (last > 1 || (size > 1 && buffer->strides[last] != 8) ||
            (rows > 1 && buffer->strides[0] % 8)) {
            PyErr_Format(PyExc_ValueError, "input %zd has no rows of numbers side by side", k);
            return -1;
        }
        if (size != 1 && size != call->lanes) {
            PyErr_Format(PyExc_ValueError, "input %zd has %zd numbers instead of 1 or %zd", k, size,
                         call->lanes);
            return -1;
        }
    }
    for (Py_ssize_t row = 0; row < rows && row < left; row++, k++) {
        int is_row = (stage->taken && stage->taken[k] >= 0) ||
                     (stage->carried && stage->carried[k] >= 0);
        if (stage->program->uniform[k] && (size != 1 || is_row)) {
            PyErr_Format(PyExc_ValueError, "input %zd has to be one number for all lanes", k);
            return -1;
        }
        if (at)
            stage->given[k] = (Input){at + row * apart, size != 1};
    }
    return rows;
}

/* Take inputs: of each one number or one for each lane, in arrays of one of them or of several,
   which are rows then; or None where they are rows of the stage before. */
static int take_inputs(Call *call, Stage *stage, PyObject *sequence)
{
    const Py_ssize_t count = stage->program->inputs;
    PyObject *inputs = PySequence_Tuple(sequence);
    if (!inputs)
        return -1;
    stage->given = calloc(2 * (size_t)count + 1, sizeof(Input));
    if (!stage->given) {
        PyErr_NoMemory();
        Py_DECREF(inputs);
        return -1;
    }
    stage->input = stage->given + count;
    Py_ssize_t taken = 0, more = 0;
    for (Py_ssize_t k = 0; more >= 0 && k < PyTuple_Size(inputs); k++, taken += more)
        more = take_input(call, stage, PyTuple_GetItem(inputs, k), taken);
    Py_DECREF(inputs);
    if (more >= 0 && taken == count)
        return 0;
    if (more >= 0)
        PyErr_Format(PyExc_ValueError, "%zd inputs are needed, not %zd", count, taken);
    return -1;
}

/* Give a call its work space, and numbers for all lanes a place in each lane of a block. */
static int make_room(Call *call)
{
    const Py_ssize_t lanes = call->machine->lanes;
    Py_ssize_t numbers = ALIGNED / 8;
    for (Py_ssize_t s = 0; s < call->count; s++) {
        const Program *program = call->stages[s].program;
        int64_t more = (program->registers + 2 * (int64_t)program->rows + program->inputs) * lanes;
        if (more > PY_SSIZE_T_MAX / 8 - numbers) {
            PyErr_NoMemory();
            return -1;
        }
        numbers += (Py_ssize_t)more;
    }
    /* What a program reads or hands out without having set it is zero. */
    call->room = calloc(numbers, 8);
    if (!call->room) {
        PyErr_NoMemory();
        return -1;
    }
    double *at = call->room;
    at += (-(uintptr_t)at % ALIGNED) / 8;
    for (Py_ssize_t s = 0; s < call->count; s++) {
        Stage *stage = &call->stages[s];
        stage->registers = at;
        stage->results = stage->registers + stage->program->registers * lanes;
        stage->earlier = stage->results + stage->program->rows * lanes;
        at = stage->earlier + stage->program->rows * lanes;
        for (Py_ssize_t k = 0; k < stage->program->inputs; k++, at += lanes) {
            if (!stage->given[k].at || stage->given[k].step)
                continue;
            for (Py_ssize_t l = 0; l < lanes; l++)
                at[l] = *stage->given[k].at;
            stage->given[k].at = at;
        }
    }
    return 0;
}

/* Run a call that was taken, unless this failed, and release it. */
static PyObject *finished(Call *call, int failed)
{
    if (!failed && make_room(call) == 0) {
        Py_BEGIN_ALLOW_THREADS
        run_call(call);
        Py_END_ALLOW_THREADS
    }
    release_call(call);
    if (PyErr_Occurred())
        return NULL;
    Py_RETURN_NONE;
}

/* run_program(program, inputs, outputs)

   Runs a program. Inputs are arrays of one number or of one for each lane, or rows of such arrays;
   `outputs` has the shape (rows, lanes). There are as many lanes as a block has, or more. */
PyObject *run_program(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 3)
    Stage *stage = calloc(1, sizeof(Stage));
    if (!stage)
        return PyErr_NoMemory();
    Call call = {.stages = stage, .count = 1};
    stage->until = -1;
    stage->most = 1;
    int failed = take_program(&call, stage, given[0]);
    const Py_buffer *outputs = failed ? NULL : take_outputs(&call, stage, given[2]);
    if (outputs) {
        call.lanes = outputs->shape[1];
        failed = check_lanes(&call) < 0 || take_inputs(&call, stage, given[1]) < 0;
    }
    return finished(&call, failed || !outputs);
}

int run_lane(PyObject *handle, const Py_buffer *inputs, const Py_buffer *outputs)
{
    const Program *program = PyCapsule_GetPointer(handle, PROGRAM);
    if (!program)
        return -1;
    const Py_ssize_t lanes = program->lanes, count = program->inputs, rows = program->rows;
    if (inputs->len != 8 * count || outputs->len != 8 * rows) {
        PyErr_Format(PyExc_ValueError, "a program of %zd inputs and %zd outputs needs as many", count,
                     rows);
        return -1;
    }
    /* What a program reads or hands out without having set it is zero. */
    double *room =
        calloc((program->registers + rows + count) * lanes + 2 * count + ALIGNED / 8, 8);
    if (!room) {
        PyErr_NoMemory();
        return -1;
    }
    const Machine *machine = machine_for(program->lanes);
    double *registers = room + (-(uintptr_t)room % ALIGNED) / 8;
    double *found = registers + program->registers * lanes, *taken = found + rows * lanes;
    Input *input = (Input *)(taken + count * lanes);
    for (Py_ssize_t k = 0; k < count; k++, taken += lanes) {
        for (Py_ssize_t l = 0; l < lanes; l++)
            taken[l] = ((const double *)inputs->buf)[k];
        input[k] = (Input){taken, 0};
    }
    machine->run(program->prologue, program->constants, (char *)registers, input, NULL, 0);
    machine->run(program->code, program->constants, (char *)registers, input, found, 0);
    for (Py_ssize_t k = 0; k < rows; k++)
        ((double *)outputs->buf)[k] = found[k * lanes];
    free(room);
    return 0;
}

/* run_one(program, inputs, outputs): run a program on one lane, soon; arrays without gaps. */
PyObject *run_one(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 3)
    Taken *held = NULL;
    const Py_buffer *inputs = take(&held, given[1], 'd', PyBUF_C_CONTIGUOUS);
    const Py_buffer *outputs =
        inputs ? take(&held, given[2], 'd', PyBUF_C_CONTIGUOUS | PyBUF_WRITABLE) : NULL;
    const int failed = !outputs || run_lane(given[0], inputs, outputs);
    release(&held);
    if (failed)
        return NULL;
    Py_RETURN_NONE;
}

/* Fields of a stage. */
enum { HANDLE, INPUTS, CARRIED, TAKEN, UNTIL, WITHIN, MOST, PASSES, OUTPUTS, FIELDS };

/* Take a stage, whose handle is taken already. */
static int take_stage(Call *call, Stage *stage, PyObject *const *fields, const Program *before)
{
    const Program *program = stage->program;
    stage->carried = take_all(&call->held, fields[CARRIED], 'i', 0, program->inputs);
    stage->taken =
        stage->carried ? take_all(&call->held, fields[TAKEN], 'i', 0, program->inputs) : NULL;
    if (!stage->taken)
        return -1;
    const Py_ssize_t rows = before ? before->rows : 0;
    for (Py_ssize_t k = 0; k < program->inputs; k++)
        if (stage->carried[k] < -1 || stage->carried[k] >= program->rows || stage->taken[k] < -1 ||
            stage->taken[k] >= rows) {
            PyErr_Format(PyExc_ValueError, "input %zd is no row of %zd, or of %zd before", k,
                         program->rows, rows);
            return -1;
        }
    stage->within = PyFloat_AsDouble(fields[WITHIN]);
    if ((stage->within == -1.0 && PyErr_Occurred()) ||
        take_count(fields[UNTIL], -1, program->rows - 1, &stage->until) < 0 ||
        take_count(fields[MOST], 1, INT32_MAX, &stage->most) < 0 ||
        take_inputs(call, stage, fields[INPUTS]) < 0)
        return -1;
    if (fields[PASSES] != Py_None) {
        Py_ssize_t blocks = (call->lanes - 1) / program->lanes + 1;
        stage->passes = take_all(&call->held, fields[PASSES], 'i', PyBUF_WRITABLE, blocks);
        if (!stage->passes)
            return -1;
    }
    if (fields[OUTPUTS] != Py_None) {
        const Py_buffer *outputs = take_outputs(call, stage, fields[OUTPUTS]);
        if (!outputs)
            return -1;
        if (outputs->shape[1] != call->lanes) {
            PyErr_Format(PyExc_ValueError, "outputs have %zd lanes instead of %zd",
                         outputs->shape[1], call->lanes);
            return -1;
        }
    }
    return 0;
}

/* Take stages, and the arguments after them: lanes, block. */
static int take_stages(Call *call, PyObject *stages, PyObject *const *rest)
{
    Py_ssize_t block;
    if (!call->count) {
        PyErr_SetString(PyExc_ValueError, "there are no stages");
        return -1;
    }
    if (take_count(rest[0], 0, PY_SSIZE_T_MAX, &call->lanes) < 0 ||
        take_count(rest[1], 4, 32, &block) < 0)
        return -1;
    for (Py_ssize_t s = 0; s < call->count; s++) {
        Stage *stage = &call->stages[s];
        const Program *before = s ? stage[-1].program : NULL;
        PyObject *fields[FIELDS], *tuple = PyTuple_GetItem(stages, s);
        if (!PyTuple_Check(tuple) || PyTuple_Size(tuple) != FIELDS) {
            PyErr_Format(PyExc_TypeError, "a stage is a tuple of %d fields", FIELDS);
            return -1;
        }
        for (int k = 0; k < FIELDS; k++)
            fields[k] = PyTuple_GetItem(tuple, k);
        if (take_program(call, stage, fields[HANDLE]) < 0)
            return -1;
        if (stage->program->lanes != block) {
            PyErr_Format(PyExc_ValueError, "the program of stage %zd is for blocks of %d, not %zd",
                         s, stage->program->lanes, block);
            return -1;
        }
        if ((!before && check_lanes(call) < 0) ||
            take_stage(call, stage, fields, before) < 0)
            return -1;
    }
    return 0;
}

/* run_stages(stages, lanes, block)

   Runs stages, one after the other on each block. A stage is a tuple of

     program   its handle
     inputs    arrays as for `run_program`; None where one is taken
     carried   for each input the row of the own last pass that it is, from the second on; or -1
     taken     for each input the row of the stage before that it is, in the first pass if it is
               carried, else in all; or -1
     until     passes end when this row is at most `within` in all lanes of the block; -1 for none
     within
     most      there are at most so many passes
     passes    array for the number of passes of each block, or None
     outputs   array (rows, lanes), or None */
PyObject *run_stages(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 3)
    /* It keeps the handles while other threads may change what was given. */
    PyObject *stages = PySequence_Tuple(given[0]);
    if (!stages)
        return NULL;
    Call call = {.count = PyTuple_Size(stages)};
    call.stages = calloc(call.count + 1, sizeof(Stage));
    if (!call.stages)
        PyErr_NoMemory();
    PyObject *result =
        finished(&call, !call.stages || take_stages(&call, stages, given + 1) < 0);
    Py_DECREF(stages);
    return result;
}

#endif
