/* The machine that runs tapes: what its compiled variants share.

   A tape is a list of instructions without jumps, each a row of eight 32-bit integers: an
   operation, what it writes, what it reads. It runs on a block of lanes at once, which are samples
   side by side; a register holds a number for each lane of the block. Registers are told by their
   number, and where a tape runs by their offset in bytes. */

#ifndef CARDAN_DYN_MACHINE_H
#define CARDAN_DYN_MACHINE_H

#include "arrays.h"

/* It is written with vectors and labels as values, which GCC and Clang have beyond C. */
#ifdef __GNUC__
#define HAS_MACHINE 1
#endif

/* Each operation jumps to the next by itself, which processors foresee better than one place where
   all do. GCC would merge what ends alike; Clang does not. */
#ifdef __clang__
#define OWN_JUMPS
#else
#define OWN_JUMPS __attribute__((optimize("no-crossjumping")))
#endif

#define ROW 8

/* Each operation and its operands, in their order in the row:

     d   register that is written                    m   the same, or -1 where it is not wanted
     s   register that is read                       i   input with a number for each lane
     u   input with one number for all lanes         k   constant
     r   row of the outputs

   A row of the table is the meaning: a, b, c ... are the registers read, in their order. Sums are
   rounded from left to right, each product and each sum by itself. The greater and the smaller of
   two numbers are NaN if either is. Outputs, and inputs with a number for each lane, are for code
   that runs for each block, not for the prologue. */
#define EVERY_OPERATION(WITH) \
    WITH(END, "")        /* the last row of each tape */ \
    WITH(LOAD, "di")     /* the input in each lane */ \
    WITH(LDU, "du")      /* the input, in all lanes */ \
    WITH(STORE, "sr")    /* the row = a */ \
    WITH(KST, "dk")      /* the constant, in all lanes */ \
    WITH(ADD, "dss")     /* a + b */ \
    WITH(SUB, "dss")     /* a - b */ \
    WITH(MUL, "dss")     /* a b */ \
    WITH(DIV, "dss")     /* a / b */ \
    WITH(RCP, "ds")      /* 1 / a */ \
    WITH(NEG, "ds")      /* -a */ \
    WITH(SQRT, "ds")     /* square root of a */ \
    WITH(SC, "mms")      /* sin a, cos a */ \
    WITH(ABS, "ds")      /* |a| */ \
    WITH(MAX, "dss")     /* a if a > b, else b */ \
    WITH(MIN, "dss")     /* a if a < b, else b */ \
    WITH(SEL, "dsss")    /* b if a > 0, else c */ \
    WITH(FMA, "dsss")    /* a b + c */ \
    WITH(FMS, "dsss")    /* a b - c */ \
    WITH(FNMA, "dsss")   /* c - a b */ \
    WITH(P2, "dssss")    /* a b + c d */ \
    WITH(M2, "dssss")    /* a b - c d */ \
    WITH(P3, "dssssss")  /* a b + c d + e f */ \
    WITH(A2, "dsssss")   /* a + b c + d e */ \
    WITH(S2, "dsssss")   /* a - b c - d e */ \
    WITH(AS, "dsssss")   /* a + b c - d e */ \
    WITH(AMX, "dss")     /* the greater of a and |b| */ \
    WITH(ADD3, "dsss")   /* a + b + c */ \
    WITH(PPM, "dssssss") /* a b + c d - e f */ \
    WITH(EXP, "ds")      /* exp a */ \
    WITH(LOG, "ds")      /* natural logarithm of a */ \
    WITH(TANH, "ds")     /* tanh a */ \
    WITH(ATAN2, "dss")   /* the angle of a point with the ordinate a and the abscissa b */ \
    WITH(PMP, "dssssss") /* a b - c d + e f */ \
    WITH(PMM, "dssssss") /* a b - c d - e f */ \
    WITH(PMA, "dsssss")  /* a b - c d + e */ \
    WITH(SA, "dsssss")   /* a - b c + d e */

/* Where an input lies: numbers of all lanes of the run, one after the other (step 1), or of the
   lanes of any block (step 0). */
typedef struct {
    const double *at;
    Py_ssize_t step;
} Input;

/* A variant of the machine, for blocks of so many lanes.

   `run` runs a tape up to its END on the block that begins at a lane; outputs are rows of the
   block. `write` brings lanes from one on, of so many rows, to where they are kept, in rows so
   far apart; `streaming` passes by the caches. */
typedef struct {
    int lanes;
    void (*run)(const int32_t *row, const double *constants, char *registers, const Input *inputs,
                double *outputs, Py_ssize_t lane);
    void (*write)(double *to, Py_ssize_t apart, const double *rows, Py_ssize_t count, int from,
                  int streaming);
} Machine;

#ifdef HAS_MACHINE
/* Run a program, in its capsule, on one lane; both arrays have no gaps. Returns -1 with an error
   set. */
int run_lane(PyObject *handle, const Py_buffer *inputs, const Py_buffer *outputs);
#else
#define run_lane(handle, inputs, outputs) (-1)
#endif

#endif
