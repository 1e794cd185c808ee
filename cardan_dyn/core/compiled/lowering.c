/* Lowering: a graph of operations as instructions of the machine, few and long ones.

   Passes, one after the other: nodes become instructions, sums of products and other patterns one
   instruction each (`lower`); outputs are stored as soon as they are known (`add_stores`); values
   get registers (`to_registers`). All round as the graph does: no sum is reassociated.

   Until values have registers, instructions read and write values: nodes by their numbers, and what
   is between nodes by the numbers after these. */

#include "kernels.h"

#ifdef HAS_MACHINE

#define ARGUMENTS 3
#define UNWANTED (-1)

/* Operations of nodes in the order of `tape/operations.py`: how many arguments each has, and the
   instruction that it is by itself. A constant and an input have their place instead. */
#define EVERY_NODE(WITH) \
    WITH(constant, 0, KST) \
    WITH(input, 0, LOAD) \
    WITH(uniform_input, 0, LDU) \
    WITH(add, 2, ADD) \
    WITH(subtract, 2, SUB) \
    WITH(multiply, 2, MUL) \
    WITH(divide, 2, DIV) \
    WITH(negative, 1, NEG) \
    WITH(sqrt, 1, SQRT) \
    WITH(sin, 1, SC) \
    WITH(cos, 1, SC) \
    WITH(absolute, 1, ABS) \
    WITH(greater, 2, MAX) \
    WITH(smaller, 2, MIN) \
    WITH(select, 3, SEL) \
    WITH(exp, 1, EXP) \
    WITH(log, 1, LOG) \
    WITH(tanh, 1, TANH) \
    WITH(arctan2, 2, ATAN2)

#define NUMBERED(name, operands) name,
enum { EVERY_OPERATION(NUMBERED) };
#undef NUMBERED

#define NUMBERED(name, arguments, instruction) of_##name,
enum { EVERY_NODE(NUMBERED) NODES };
#undef NUMBERED

#define COUNTED(name, arguments, instruction) arguments,
static const int arities[] = {EVERY_NODE(COUNTED)};
#undef COUNTED

#define OPERANDS(name, operands) operands,
static const char *const operands_of[] = {EVERY_OPERATION(OPERANDS)};
#undef OPERANDS

/* Terms of sums: + a, - a, + a b, - a b. */
enum { A = 1, S, P, N, KINDS };

/* Sums that are one instruction, computed from left to right. The first two terms may be exchanged,
   which rounds alike; so each sum of two terms that begins with + is one. */
static const unsigned char sums[KINDS][KINDS][KINDS] = {
    [A][A][0] = ADD, [A][S][0] = SUB, [P][A][0] = FMA, [P][S][0] = FMS, [N][A][0] = FNMA,
    [P][P][0] = P2,  [P][N][0] = M2,  [A][A][A] = ADD3, [P][N][A] = PMA, [A][P][P] = A2,
    [A][P][N] = AS,  [A][N][P] = SA,  [A][N][N] = S2,   [P][P][P] = P3,  [P][P][N] = PPM,
    [P][N][P] = PMP, [P][N][N] = PMM,
};

/* An instruction: an operation, and its operands as `machine.h` has them. */
typedef int32_t Row[ROW];

typedef struct {
    int32_t kind, values[2]; /* Of a product both factors, else the value. */
} Term;

typedef struct {
    Row *rows;
    Py_ssize_t count;
} Rows;

typedef struct {
    /* The graph. */
    int32_t nodes, outputs;
    const int32_t *operations, *output;
    const int32_t (*arguments)[ARGUMENTS];
    const double *constants;
    /* Of each node: whether it has one value for all lanes; how many read it; whether it is a part
       of the instruction of its reader; which nodes are the sine and the cosine of it, or -1. */
    int32_t *uniform, *uses, *absorbed, *sines, *cosines;
    /* Of each node the first output that it is, or -1; of each output the next one of its node. */
    int32_t *first, *next;
    Term *terms; /* One more than nodes: of the sum in work, at their end. */
    /* Of each value: its register, or -1; the last instruction that reads it. How many there are. */
    int32_t *registers, *last, values;
    int32_t *unused;
    Rows prologue, body, stored;
} Lowering;

/* ------------------------------------------------------------------------------- nodes */

/* Return the operation of a node that can be a part of the one that reads it, -1 of others: no other
   reads it, and it differs from lane to lane. */
static int32_t part(const Lowering *of, int32_t node)
{
    return of->uses[node] == 1 && !of->uniform[node] ? of->operations[node] : -1;
}

static int is_sum(int32_t operation)
{
    return operation == of_add || operation == of_subtract;
}

static void set_term(Lowering *of, Term *term, int32_t node, int is_subtracted)
{
    *term = (Term){is_subtracted ? S : A, {node, UNWANTED}};
    if (part(of, node) == of_multiply) {
        of->absorbed[node] = 1;
        *term = (Term){is_subtracted ? N : P, {of->arguments[node][0], of->arguments[node][1]}};
    }
}

/* Return the first term of a sum; they stand in the order in which they are added. */
static Term *terms_of(Lowering *of, int32_t node)
{
    Term *term = of->terms + of->nodes + 1;
    for (;;) {
        int32_t left = of->arguments[node][0], right = of->arguments[node][1];
        const int is_subtracted = of->operations[node] == of_subtract;
        if (!is_subtracted && is_sum(part(of, right))) {
            int32_t other = left;
            left = right;
            right = other;
        }
        set_term(of, --term, right, is_subtracted);
        if (!is_sum(part(of, left))) {
            set_term(of, --term, left, 0);
            return term;
        }
        of->absorbed[left] = 1;
        node = left;
    }
}

/* Return the operation of the greater of two, one of which may be an absolute value, and what it
   reads. */
static int greater_of(Lowering *of, int32_t node, int32_t *read)
{
    const int32_t *arguments = of->arguments[node];
    const int is_first = part(of, arguments[0]) == of_absolute;
    const int32_t b = arguments[!is_first];
    read[0] = arguments[is_first];
    read[1] = b;
    if (part(of, b) != of_absolute)
        return MAX;
    of->absorbed[b] = 1;
    read[1] = of->arguments[b][0];
    return AMX;
}

static int32_t *add_row(Rows *rows, int32_t operation)
{
    int32_t *row = rows->rows[rows->count++];
    row[0] = operation;
    return row;
}

static void lower_sum(Lowering *of, Rows *rows, int32_t node)
{
    Term *term = terms_of(of, node), *end = of->terms + of->nodes + 1;
    while (end - term > 1) {
        int count = end - term > 2 ? 3 : 2, exchanged = 0, operation;
        while (!(operation = sums[term[exchanged].kind][term[!exchanged].kind]
                                 [count == 3 ? term[2].kind : 0])) {
            count -= exchanged;
            exchanged = !exchanged;
        }
        int32_t *row = add_row(rows, operation), *operand = row + 1;
        *operand++ = end - term == count ? node : of->values++;
        for (int k = 0; k < count; k++) {
            const Term *taken = &term[k < 2 ? k ^ exchanged : k];
            *operand++ = taken->values[0];
            if (taken->kind == P || taken->kind == N)
                *operand++ = taken->values[1];
        }
        term += count - 1;
        *term = (Term){A, {row[1], UNWANTED}};
    }
}

static void lower_node(Lowering *of, Rows *rows, int32_t node)
{
#define PLAIN(name, arguments, instruction) instruction,
    static const unsigned char plain[] = {EVERY_NODE(PLAIN)};
#undef PLAIN
    const int32_t operation = of->operations[node], *arguments = of->arguments[node];
    int32_t *row;
    switch (operation) {
    case of_add:
    case of_subtract:
        lower_sum(of, rows, node);
        return;
    case of_sin:
    case of_cos: {
        /* One instruction for both, by the first of them. */
        const int32_t sine = of->sines[arguments[0]], cosine = of->cosines[arguments[0]];
        if ((operation == of_sin ? cosine : sine) < node &&
            (operation == of_sin ? cosine : sine) != UNWANTED)
            return;
        row = add_row(rows, SC);
        row[1] = sine;
        row[2] = cosine;
        row[3] = arguments[0];
        return;
    }
    case of_greater:
        row = add_row(rows, MAX);
        row[0] = greater_of(of, node, row + 2);
        break;
    case of_divide:
        if (of->operations[arguments[0]] == of_constant &&
            of->constants[of->arguments[arguments[0]][0]] == 1.0) {
            row = add_row(rows, RCP);
            row[2] = arguments[1];
            break;
        }
        /* fallthrough */
    default:
        row = add_row(rows, plain[operation]);
        for (int k = 0; k < arities[operation]; k++)
            row[2 + k] = arguments[k];
        if (!arities[operation])
            row[2] = arguments[0];
    }
    row[1] = node;
}

/* Nodes become instructions: of the prologue where they have one value for all lanes. */
static void lower(Lowering *of)
{
    int32_t read[ARGUMENTS];
    /* From the outputs on: a node takes its parts before these are written down. */
    for (int32_t node = of->nodes - 1; node >= 0; node--)
        if (!of->absorbed[node]) {
            if (is_sum(of->operations[node]))
                terms_of(of, node);
            else if (of->operations[node] == of_greater)
                greater_of(of, node, read);
        }
    for (int32_t node = 0; node < of->nodes; node++)
        if (!of->absorbed[node])
            lower_node(of, of->uniform[node] ? &of->prologue : &of->body, node);
}

/* ------------------------------------------------------------------ stores and registers */

static void store(Lowering *of, int32_t value)
{
    if (value < 0 || value >= of->nodes)
        return;
    for (int32_t output = of->first[value]; output >= 0; output = of->next[output]) {
        int32_t *row = add_row(&of->stored, STORE);
        row[1] = value;
        row[2] = output;
    }
}

/* Outputs are stored as soon as they are known, those with one value for all lanes at first. */
static void add_stores(Lowering *of)
{
    for (int32_t output = 0; output < of->outputs; output++)
        if (of->uniform[of->output[output]] && of->first[of->output[output]] == output)
            store(of, of->output[output]);
    for (Py_ssize_t k = 0; k < of->body.count; k++) {
        const int32_t *row = of->body.rows[k];
        memcpy(of->stored.rows[of->stored.count++], row, sizeof(Row));
        for (const char *kind = operands_of[*row++]; *kind == 'd' || *kind == 'm'; kind++)
            store(of, *row++);
    }
}

/* Values of the prologue get registers that stay; returns how many. */
static int32_t pin(Lowering *of)
{
    int32_t pinned = 0;
    for (Py_ssize_t k = 0; k < of->prologue.count; k++) {
        const int32_t *row = of->prologue.rows[k];
        for (const char *kind = operands_of[*row++]; *kind == 'd' || *kind == 'm'; kind++, row++)
            if (*row != UNWANTED)
                of->registers[*row] = pinned++;
    }
    return pinned;
}

/* Instructions get registers; returns how many there are. A register is free again where nothing
   reads its value later. An instruction may write over a value that it is the last to read. */
static int32_t to_registers(Lowering *of, Rows *rows, int32_t pinned)
{
    int32_t count = pinned, *unused = of->unused;
    for (Py_ssize_t k = 0; k < rows->count; k++) {
        const int32_t *row = rows->rows[k];
        for (const char *kind = operands_of[*row++]; *kind; kind++, row++)
            if (*kind == 's')
                of->last[*row] = (int32_t)k;
    }
    for (Py_ssize_t k = 0; k < rows->count; k++) {
        const char *kinds = operands_of[rows->rows[k][0]];
        int32_t *operands = rows->rows[k] + 1;
        int written = 0;
        for (int j = 0; kinds[j]; j++) {
            written += kinds[j] == 'd' || kinds[j] == 'm';
            if (kinds[j] != 's')
                continue;
            const int32_t value = operands[j];
            operands[j] = of->registers[value];
            if (of->last[value] == k && operands[j] >= pinned)
                *unused++ = operands[j];
            of->last[value] = of->last[value] == k ? -1 : of->last[value];
        }
        for (int j = 0; j < written; j++) {
            if (operands[j] == UNWANTED)
                continue;
            int32_t *at = &of->registers[operands[j]];
            if (*at < 0)
                *at = unused > of->unused ? *--unused : count++;
            operands[j] = *at;
        }
    }
    return count;
}

/* ------------------------------------------------------------------------------- graphs */

/* Give a lowering its work space: integers that are zero. Returns NULL with an error set. */
static void *make_room(Lowering *of)
{
    const size_t nodes = of->nodes, outputs = of->outputs, values = 2 * nodes;
    int32_t **parts[] = {&of->uniform, &of->uses, &of->absorbed,  &of->sines, &of->cosines,
                         &of->first,   &of->next, &of->registers, &of->last,  &of->unused};
    const size_t sizes[] = {nodes, nodes,   nodes,  nodes,  nodes,
                            nodes, outputs, values, values, values};
    const size_t rows = 3 * nodes + outputs + 2;
    size_t count = 3 * (nodes + 1) + ROW * rows;
    for (size_t k = 0; k < sizeof(sizes) / sizeof(*sizes); k++)
        count += sizes[k];
    int32_t *room = calloc(count, sizeof(int32_t)), *at = room;
    if (!room) {
        PyErr_NoMemory();
        return NULL;
    }
    for (size_t k = 0; k < sizeof(sizes) / sizeof(*sizes); k++) {
        *parts[k] = at;
        at += sizes[k];
    }
    of->terms = (Term *)at;
    of->prologue.rows = (Row *)(at + 3 * (nodes + 1));
    of->body.rows = of->prologue.rows + nodes + 1;
    of->stored.rows = of->body.rows + nodes;
    return room;
}

/* Whether a node is written once, after its arguments, and has its place. */
static int is_node(Lowering *of, int32_t node, Py_ssize_t constants)
{
    const int32_t operation = of->operations[node], *arguments = of->arguments[node];
    if (operation < 0 || operation >= NODES)
        return 0;
    of->uniform[node] = operation != of_input;
    for (int k = 0; k < arities[operation]; k++) {
        if (arguments[k] < 0 || arguments[k] >= node)
            return 0;
        of->uniform[node] &= of->uniform[arguments[k]];
        of->uses[arguments[k]]++;
    }
    if (operation == of_sin || operation == of_cos) {
        int32_t *known = (operation == of_sin ? of->sines : of->cosines) + arguments[0];
        if (*known != UNWANTED)
            return 0;
        *known = node;
    }
    return operation != of_constant || (arguments[0] >= 0 && arguments[0] < constants);
}

/* Read a graph; -1 with an error set if it is none. */
static int read_graph(Lowering *of, Py_ssize_t constants)
{
    for (int32_t node = 0; node < of->nodes; node++) {
        of->sines[node] = of->cosines[node] = of->first[node] = UNWANTED;
        if (!is_node(of, node, constants)) {
            PyErr_Format(PyExc_ValueError, "node %d of a graph does not fit", (int)node);
            return -1;
        }
    }
    for (int32_t output = of->outputs - 1; output >= 0; output--) {
        const int32_t node = of->output[output];
        if (node < 0 || node >= of->nodes) {
            PyErr_Format(PyExc_ValueError, "output %d of a graph is no node", (int)output);
            return -1;
        }
        of->uses[node]++;
        of->next[output] = of->first[node];
        of->first[node] = output;
    }
    of->values = of->nodes;
    memset(of->registers, -1, 2 * sizeof(int32_t) * of->nodes);
    return 0;
}

static PyObject *instructions_of(Lowering *of, Py_ssize_t constants)
{
    void *room = make_room(of);
    PyObject *result = NULL;
    if (room && read_graph(of, constants) == 0) {
        lower(of);
        add_stores(of);
        const int32_t pinned = pin(of);
        to_registers(of, &of->prologue, pinned);
        const int32_t registers = to_registers(of, &of->stored, pinned);
        /* An END, which is zero, closes both. */
        result = Py_BuildValue("(y#y#i)", of->prologue.rows,
                               (Py_ssize_t)sizeof(Row) * (of->prologue.count + 1), of->stored.rows,
                               (Py_ssize_t)sizeof(Row) * (of->stored.count + 1), (int)registers);
    }
    free(room);
    return result;
}

/* instructions(operations, arguments, constants, outputs)

   Returns prologue and code of a graph as bytes, rows for `program`, and how many registers they
   need. Of n nodes `operations` (n) are their numbers, `arguments` (n, 3) nodes before each; of a
   constant its place among `constants`, of an input that among inputs. `outputs` are nodes. */
PyObject *instructions(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 4)
    const Py_buffer *buffers[4];
    Taken *held = NULL;
    PyObject *result = NULL;
    for (int k = 0; k < 4; k++)
        if (!(buffers[k] = take(&held, given[k], k == 2 ? 'd' : 'i', PyBUF_C_CONTIGUOUS)))
            goto done;
    const Py_ssize_t nodes = buffers[0]->len / 4, outputs = buffers[3]->len / 4;
    if (buffers[1]->len != ARGUMENTS * buffers[0]->len)
        PyErr_Format(PyExc_ValueError, "%zd nodes need %d arguments each", nodes, ARGUMENTS);
    else if (nodes > INT32_MAX / 256 || outputs > INT32_MAX / 256)
        PyErr_Format(PyExc_ValueError, "%zd nodes and %zd outputs are too many", nodes, outputs);
    else {
        Lowering of = {.nodes = (int32_t)nodes, .outputs = (int32_t)outputs};
        of.operations = buffers[0]->buf;
        of.arguments = buffers[1]->buf;
        of.constants = buffers[2]->buf;
        of.output = buffers[3]->buf;
        result = instructions_of(&of, buffers[2]->len / 8);
    }
done:
    release(&held);
    return result;
}

#endif
