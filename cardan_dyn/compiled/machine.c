/* Tapes run on blocks of lanes: one program, or several as stages that hand on their results.

   A program is a prologue, which runs once in a call, its constants, and its code, which runs for
   each block; both work on the same registers. All that they say is checked before anything runs:
   no instruction reads or writes what is not the call's. Blocks begin at the first lane of a call
   and every so many further on. The last block of the arrays lies over lanes of the one before it,
   but only writes its own, so that nothing depends on how calls share the lanes among them. */

#include "kernels.h"

#ifdef HAS_MACHINE

#ifdef __x86_64__
#include <immintrin.h>
#endif

/* Sines and cosines: angles are taken apart into k pi/2 and a rest. Products of k with the first
   two parts of pi/2, of 33 bits each, are exact up to 2^20. The third is what is left, but for
   1e-37; of the worst angle up to FARTHEST, which is 1e-16 from a multiple of pi/2, this leaves a
   rest that is right to half a unit in the last place. */
#define FARTHEST 1e5
#define PI 3.141592653589793
#define QUARTER_1 0x1.921fb544p+0
#define QUARTER_2 0x1.0b4611a6p-34
#define QUARTER_3 0x1.3198a2e037073p-69
/* Added to a number, it leaves no bits behind the point. */
#define UNITS 0x1.8p+52
#define FACTORIAL_3 6.0
#define FACTORIAL_4 24.0
#define FACTORIAL_5 120.0
#define FACTORIAL_6 720.0
#define FACTORIAL_7 5040.0
#define FACTORIAL_8 40320.0
#define FACTORIAL_9 362880.0
#define FACTORIAL_10 3628800.0
#define FACTORIAL_11 39916800.0
#define FACTORIAL_12 479001600.0
#define FACTORIAL_13 6227020800.0
#define FACTORIAL_14 87178291200.0
#define FACTORIAL_15 1307674368000.0
#define FACTORIAL_16 20922789888000.0
#define FACTORIAL_17 355687428096000.0

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
#define STAGE_FIELDS 13

typedef struct {
    const int32_t *prologue, *code;
    const double *constants;
    Py_ssize_t prologue_rows, code_rows, constant_count, registers, inputs, rows;
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
    double *bank;
    Input *input;
    double *results, *earlier;
} Stage;

/* An array that a call holds; they are a list. */
typedef struct Taken {
    Py_buffer buffer;
    struct Taken *next;
} Taken;

typedef struct {
    const Machine *machine;
    Py_ssize_t lanes, first, last; /* of the arrays, and those that run */
    Stage *stages;
    Py_ssize_t count;
    Taken *held;
    void *room;
} Call;

/* ------------------------------------------------------------------------------- running */

/* Bring the lanes of a block from one on, and before the last of the call, to the outputs. */
static void write_outputs(const Call *call, const Stage *stage, Py_ssize_t block, Py_ssize_t from)
{
    const int lanes = call->machine->lanes;
    const int skipped = (int)(from - block);
    const int end = call->last - block < lanes ? (int)(call->last - block) : lanes;
    for (Py_ssize_t row = 0; row < stage->rows; row++)
        call->machine->write(stage->outputs + row * stage->apart + block,
                             stage->results + row * lanes, skipped, end, stage->streaming);
}

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
    for (Py_ssize_t k = 0; k < stage->inputs; k++)
        if (stage->taken && stage->taken[k] >= 0)
            stage->input[k] = (Input){before + stage->taken[k] * machine->lanes, 0};
        else
            stage->input[k] = stage->given[k];
    for (Py_ssize_t passes = 1;; passes++) {
        machine->run(stage->code, stage->constants, (char *)stage->bank, stage->input,
                     stage->results, block);
        if (passes >= stage->most || is_done(stage, machine->lanes))
            return passes;
        for (Py_ssize_t k = 0; stage->carried && k < stage->inputs; k++)
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
        Stage *stage = &call->stages[s];
        machine->run(stage->prologue, stage->constants, (char *)stage->bank, stage->given, NULL, 0);
    }
    for (Py_ssize_t from = call->first; from < call->last; from += machine->lanes) {
        Py_ssize_t block =
            from + machine->lanes <= call->lanes ? from : call->lanes - machine->lanes;
        const double *before = NULL;
        for (Py_ssize_t s = 0; s < call->count; s++) {
            Stage *stage = &call->stages[s];
            Py_ssize_t passes = run_passes(machine, stage, before, block);
            before = stage->results;
            if (stage->passes)
                stage->passes[from / machine->lanes] = (int32_t)passes;
            if (stage->outputs)
                write_outputs(call, stage, block, from);
        }
    }
#ifdef __x86_64__
    /* What passed by the caches is seen by whoever is told that the call is over. */
    _mm_sfence();
#endif
}

/* ------------------------------------------------------------------------------ checking */

/* Checks return 0, or -1 with an error set. */

/* Whether a number is the same in all lanes and passes. */
static int is_uniform(const Stage *stage, int64_t input)
{
    return stage->given[input].at && !stage->given[input].step &&
           !(stage->carried && (stage->carried[input] >= 0 || stage->taken[input] >= 0));
}

/* Whether each operand of an instruction is one that there is. */
static int is_instruction(const Stage *stage, const int32_t *row, int64_t size, int is_prologue)
{
#define OPERANDS(name, operands) operands,
    static const char *const operands[] = {EVERY_OPERATION(OPERANDS)};
#undef OPERANDS
    if (row[0] < 0 || row[0] >= (int32_t)(sizeof(operands) / sizeof(*operands)))
        return 0;
    int is_one = 1;
    for (const char *kind = operands[*row++]; *kind; kind++, row++) {
        int64_t at = *row, end = size * stage->registers;
        if (*kind == 'm' && at == -1)
            continue;
        if (*kind == 'i' || *kind == 'u')
            end = stage->inputs;
        if (*kind == 'k')
            end = stage->constant_count;
        if (*kind == 'r')
            end = stage->rows;
        if (at < 0 || at >= end)
            return 0;
        if (*kind == 'd' || *kind == 'm' || *kind == 's')
            is_one &= at % size == 0;
        if (*kind == 'i' || *kind == 'r')
            is_one &= !is_prologue;
        if (*kind == 'u')
            is_one &= is_uniform(stage, at);
    }
    return is_one;
}

/* Check that a tape ends, and all its instructions. */
static int check_tape(const Call *call, const Stage *stage, int is_prologue)
{
    const char *name = is_prologue ? "prologue" : "code";
    const int32_t *tape = is_prologue ? stage->prologue : stage->code;
    Py_ssize_t rows = is_prologue ? stage->prologue_rows : stage->code_rows;
    if (!rows || tape[ROW * (rows - 1)] != 0) {
        PyErr_Format(PyExc_ValueError, "the %s of a program does not end", name);
        return -1;
    }
    for (Py_ssize_t k = 0; k < rows; k++)
        if (!is_instruction(stage, tape + ROW * k, 8 * call->machine->lanes, is_prologue)) {
            PyErr_Format(PyExc_ValueError, "instruction %zd in the %s of a program does not fit", k,
                         name);
            return -1;
        }
    return 0;
}

/* Check that each input comes from somewhere, and both tapes. */
static int check_program(const Call *call, const Stage *stage)
{
    for (Py_ssize_t k = 0; k < stage->inputs; k++)
        if (!stage->given[k].at && !(stage->taken && stage->taken[k] >= 0)) {
            PyErr_Format(PyExc_ValueError, "input %zd is not given", k);
            return -1;
        }
    return check_tape(call, stage, 1) < 0 ? -1 : check_tape(call, stage, 0);
}

/* Check rows of outputs that inputs are instead. */
static int check_rows(const int32_t *rows, Py_ssize_t count, Py_ssize_t end)
{
    for (Py_ssize_t k = 0; k < count; k++)
        if (rows[k] < -1 || rows[k] >= end) {
            PyErr_Format(PyExc_ValueError, "input %zd cannot be row %d of %zd", k, (int)rows[k],
                         end);
            return -1;
        }
    return 0;
}

/* -------------------------------------------------------------------------------- taking */

/* Functions return NULL or -1 with an error set. */

static void release_call(Call *call)
{
    while (call->held) {
        Taken *next = call->held->next;
        PyBuffer_Release(&call->held->buffer);
        free(call->held);
        call->held = next;
    }
    for (Py_ssize_t s = 0; call->stages && s < call->count; s++)
        free(call->stages[s].given);
    free(call->stages);
    free(call->room);
}

/* Take an array of doubles, "d", or of 32-bit integers, "i". */
static const Py_buffer *take_array(Call *call, PyObject *object, char type, int flags)
{
    Taken *taken = malloc(sizeof(Taken));
    if (!taken) {
        PyErr_NoMemory();
        return NULL;
    }
    if (PyObject_GetBuffer(object, &taken->buffer, flags | PyBUF_FORMAT) < 0) {
        free(taken);
        return NULL;
    }
    taken->next = call->held;
    call->held = taken;
    const Py_buffer *buffer = &taken->buffer;
    const char *format = buffer->format;
    /* Where a long has 32 bits, they are told by its letter. */
    int has_type = format[0] == type || (type == 'i' && format[0] == 'l');
    if (!has_type || format[1] || buffer->itemsize != (type == 'd' ? 8 : 4)) {
        PyErr_Format(PyExc_TypeError, "an array of %s is needed",
                     type == 'd' ? "numbers" : "32-bit integers");
        return NULL;
    }
    if ((uintptr_t)buffer->buf % buffer->itemsize) {
        PyErr_SetString(PyExc_ValueError, "numbers of an array lie across their boundaries");
        return NULL;
    }
    return buffer;
}

/* Take so many integers. */
static int32_t *take_integers(Call *call, PyObject *object, Py_ssize_t count, int flags)
{
    const Py_buffer *buffer = take_array(call, object, 'i', PyBUF_C_CONTIGUOUS | flags);
    if (!buffer)
        return NULL;
    if (buffer->len / 4 != count) {
        PyErr_Format(PyExc_ValueError, "%zd integers are needed, not %zd", count, buffer->len / 4);
        return NULL;
    }
    return buffer->buf;
}

static const int32_t *take_tape(Call *call, PyObject *object, Py_ssize_t *rows)
{
    const Py_buffer *buffer = take_array(call, object, 'i', PyBUF_C_CONTIGUOUS);
    if (!buffer)
        return NULL;
    if (buffer->ndim != 2 || buffer->shape[1] != ROW) {
        PyErr_Format(PyExc_ValueError, "instructions are rows of %d integers", ROW);
        return NULL;
    }
    *rows = buffer->shape[0];
    return buffer->buf;
}

/* Take inputs: one number, one for each lane, or None. */
static int take_inputs(Call *call, Stage *stage, PyObject *inputs)
{
    stage->inputs = PyTuple_Size(inputs);
    stage->given = calloc(2 * (size_t)stage->inputs + 1, sizeof(Input));
    if (!stage->given) {
        PyErr_NoMemory();
        return -1;
    }
    stage->input = stage->given + stage->inputs;
    for (Py_ssize_t k = 0; k < stage->inputs; k++) {
        PyObject *input = PyTuple_GetItem(inputs, k);
        if (input == Py_None)
            continue;
        const Py_buffer *buffer = take_array(call, input, 'd', PyBUF_C_CONTIGUOUS);
        if (!buffer)
            return -1;
        Py_ssize_t size = buffer->len / 8;
        if (size != 1 && size != call->lanes) {
            PyErr_Format(PyExc_ValueError, "input %zd has %zd numbers instead of 1 or %zd", k, size,
                         call->lanes);
            return -1;
        }
        stage->given[k] = (Input){buffer->buf, size != 1};
    }
    return 0;
}

/* Take an array for outputs, of which numbers of a row lie side by side. */
static const Py_buffer *take_outputs(Call *call, Stage *stage, PyObject *object)
{
    const Py_buffer *buffer = take_array(call, object, 'd', PyBUF_STRIDES | PyBUF_WRITABLE);
    if (!buffer)
        return NULL;
    if (buffer->ndim != 2 || (buffer->shape[1] > 1 && buffer->strides[1] != 8) ||
        buffer->strides[0] % 8) {
        PyErr_SetString(PyExc_ValueError, "outputs are rows of numbers side by side");
        return NULL;
    }
    stage->outputs = buffer->buf;
    stage->apart = buffer->strides[0] / 8;
    stage->streaming = 1;
    return buffer;
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

/* Take the number of lanes in a block, and find the machine for it. CARDAN_DYN_AVX2=0 in the
   environment does without these instructions. */
static int take_machine(Call *call, PyObject *object)
{
    long lanes = PyLong_AsLong(object);
    if (lanes == -1 && PyErr_Occurred())
        return -1;
    if (lanes != 4 && lanes != 32) {
        PyErr_Format(PyExc_ValueError, "blocks have 4 lanes or 32, not %ld", lanes);
        return -1;
    }
    call->machine = lanes == 4 ? &machine_4 : &machine_32;
#ifdef __x86_64__
    const char *wanted = getenv("CARDAN_DYN_AVX2");
    if (__builtin_cpu_supports("avx2") && !(wanted && strcmp(wanted, "0") == 0))
        call->machine = lanes == 4 ? &machine_4_avx2 : &machine_32_avx2;
#endif
    return 0;
}

/* Take which lanes are to run: the first, which starts a block, and the one after the last. */
static int take_lanes(Call *call, PyObject *const *span)
{
    const int block = call->machine->lanes;
    if (call->lanes < block) {
        PyErr_Format(PyExc_ValueError, "%zd lanes are fewer than a block of %d", call->lanes, block);
        return -1;
    }
    if (take_count(span[1], 0, call->lanes, &call->last) < 0 ||
        take_count(span[0], 0, call->last, &call->first) < 0)
        return -1;
    if (call->first % block) {
        PyErr_Format(PyExc_ValueError, "lane %zd does not start a block of %d", call->first, block);
        return -1;
    }
    return 0;
}

/* How many registers or rows there may be, so that 32 bits tell their places in bytes. */
static Py_ssize_t most_rows(const Call *call)
{
    return INT32_MAX / (8 * call->machine->lanes);
}

/* Take the five fields of a program: prologue, constants, code, registers, inputs. */
static int take_program(Call *call, Stage *stage, PyObject *const *fields)
{
    const Py_buffer *constants = take_array(call, fields[1], 'd', PyBUF_C_CONTIGUOUS);
    if (!constants)
        return -1;
    stage->constants = constants->buf;
    stage->constant_count = constants->len / 8;
    stage->prologue = take_tape(call, fields[0], &stage->prologue_rows);
    stage->code = stage->prologue ? take_tape(call, fields[2], &stage->code_rows) : NULL;
    if (!stage->code || take_count(fields[3], 0, most_rows(call), &stage->registers) < 0)
        return -1;
    PyObject *inputs = PySequence_Tuple(fields[4]);
    int failed = inputs ? take_inputs(call, stage, inputs) : -1;
    Py_XDECREF(inputs);
    return failed;
}

/* Give a call its work space, and numbers for all lanes a place in each lane of a block. */
static int make_room(Call *call)
{
    const Py_ssize_t lanes = call->machine->lanes;
    Py_ssize_t numbers = ALIGNED / 8;
    for (Py_ssize_t s = 0; s < call->count; s++) {
        const Stage *stage = &call->stages[s];
        int64_t more = (stage->registers + 2 * (int64_t)stage->rows + stage->inputs) * lanes;
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
        stage->bank = at;
        stage->results = stage->bank + stage->registers * lanes;
        stage->earlier = stage->results + stage->rows * lanes;
        at = stage->earlier + stage->rows * lanes;
        for (Py_ssize_t k = 0; k < stage->inputs; k++, at += lanes) {
            if (!stage->given[k].at || stage->given[k].step)
                continue;
            for (Py_ssize_t l = 0; l < lanes; l++)
                at[l] = *stage->given[k].at;
            stage->given[k].at = at;
        }
    }
    return 0;
}

static PyObject *run_and_release(Call *call)
{
    Py_BEGIN_ALLOW_THREADS
    run_call(call);
    Py_END_ALLOW_THREADS
    release_call(call);
    Py_RETURN_NONE;
}

/* run_program(prologue, constants, code, registers, inputs, outputs, block, first, last)

   Runs a program on lanes from `first`, which starts a block, up to `last`. `prologue` and `code`
   are instructions; `inputs` are arrays of one number or of one for each lane; `outputs` has the
   shape (rows, lanes); a block has 4 lanes or 32, and there are at least as many lanes. */
PyObject *run_program(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 9)
    Call call = {.count = 1, .stages = calloc(1, sizeof(Stage))};
    if (!call.stages)
        return PyErr_NoMemory();
    Stage *stage = call.stages;
    stage->until = -1;
    stage->most = 1;
    if (take_machine(&call, given[6]) < 0)
        goto failed;
    const Py_buffer *outputs = take_outputs(&call, stage, given[5]);
    if (!outputs)
        goto failed;
    stage->rows = outputs->shape[0];
    call.lanes = outputs->shape[1];
    if (stage->rows > most_rows(&call)) {
        PyErr_SetString(PyExc_ValueError, "there are too many outputs");
        goto failed;
    }
    if (take_lanes(&call, given + 7) == 0 && take_program(&call, stage, given) == 0 &&
        check_program(&call, stage) == 0 && make_room(&call) == 0)
        return run_and_release(&call);
failed:
    release_call(&call);
    return NULL;
}

/* Take the fields of a stage. After those of a program these are: how many outputs it has; for each
   input the row of its own last pass, and that of the stage before, or -1; the row that ends
   passes, or -1; its bound; how many passes there are at most; an array for the passes of each
   block, or None; an array for its outputs, or None. */
static int take_stage(Call *call, Stage *stage, PyObject *const *fields, const Stage *before)
{
    if (take_count(fields[5], 0, most_rows(call), &stage->rows) < 0 ||
        take_program(call, stage, fields) < 0)
        return -1;
    stage->carried = take_integers(call, fields[6], stage->inputs, 0);
    stage->taken = stage->carried ? take_integers(call, fields[7], stage->inputs, 0) : NULL;
    if (!stage->taken || check_rows(stage->carried, stage->inputs, stage->rows) < 0 ||
        check_rows(stage->taken, stage->inputs, before ? before->rows : 0) < 0 ||
        take_count(fields[8], -1, stage->rows - 1, &stage->until) < 0 ||
        take_count(fields[10], 1, INT32_MAX, &stage->most) < 0)
        return -1;
    stage->within = PyFloat_AsDouble(fields[9]);
    if (stage->within == -1.0 && PyErr_Occurred())
        return -1;
    if (fields[11] != Py_None) {
        Py_ssize_t blocks = (call->lanes - 1) / call->machine->lanes + 1;
        stage->passes = take_integers(call, fields[11], blocks, PyBUF_WRITABLE);
        if (!stage->passes)
            return -1;
    }
    if (fields[12] != Py_None) {
        const Py_buffer *outputs = take_outputs(call, stage, fields[12]);
        if (!outputs)
            return -1;
        if (outputs->shape[0] != stage->rows || outputs->shape[1] != call->lanes) {
            PyErr_Format(PyExc_ValueError,
                         "outputs have the shape (%zd, %zd) instead of (%zd, %zd)",
                         outputs->shape[0], outputs->shape[1], stage->rows, call->lanes);
            return -1;
        }
    }
    return check_program(call, stage);
}

static int take_stages(Call *call, PyObject *stages)
{
    for (Py_ssize_t s = 0; s < call->count; s++) {
        PyObject *fields[STAGE_FIELDS], *stage = PyTuple_GetItem(stages, s);
        if (!PyTuple_Check(stage) || PyTuple_Size(stage) != STAGE_FIELDS) {
            PyErr_Format(PyExc_TypeError, "a stage is a tuple of %d fields", STAGE_FIELDS);
            return -1;
        }
        for (int k = 0; k < STAGE_FIELDS; k++)
            fields[k] = PyTuple_GetItem(stage, k);
        if (take_stage(call, &call->stages[s], fields, s ? &call->stages[s - 1] : NULL) < 0)
            return -1;
    }
    return 0;
}

/* run_stages(stages, lanes, block, first, last)

   Runs stages one after the other on each block. A stage is a tuple: prologue, constants, code,
   registers and inputs as for `run_program`, and what `take_stage` says. An input that is a row of
   the stage before may be None; one that is carried is given for the first pass. */
PyObject *run_stages(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 5)
    PyObject *stages = PySequence_Tuple(given[0]);
    if (!stages)
        return NULL;
    Call call = {.count = PyTuple_Size(stages)};
    call.stages = calloc(call.count + 1, sizeof(Stage));
    int failed = -1;
    if (!call.stages)
        PyErr_NoMemory();
    else if (take_machine(&call, given[2]) == 0 &&
             take_count(given[1], 0, PY_SSIZE_T_MAX, &call.lanes) == 0 &&
             take_lanes(&call, given + 3) == 0 && take_stages(&call, stages) == 0)
        failed = make_room(&call);
    Py_DECREF(stages);
    if (!failed)
        return run_and_release(&call);
    release_call(&call);
    return NULL;
}

#endif
