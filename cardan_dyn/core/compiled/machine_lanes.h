/* The text of the machine, compiled for each set of instructions and each size of blocks.

   Before it is included, these are defined: LANES in a block; WIDTH, numbers in a vector; TARGET,
   the attribute of functions for the set of instructions; STREAM(to, vector), a store that passes
   by the caches; NAMED(name), a name of its own. What is rounded is the same in all variants: no
   product is fused with a sum, and each lane goes through the same operations. */

#define VECTORS (LANES / WIDTH)
#define EACH_VECTOR _Pragma("GCC unroll 16") for (int i = 0; i < VECTORS; i++)
#define EACH_LANE for (int l = 0; l < LANES; l++)
#define HELPER static inline __attribute__((always_inline)) TARGET

#define Numbers NAMED(Numbers)
#define Unaligned NAMED(Unaligned)
#define Bits NAMED(Bits)
typedef double Numbers __attribute__((vector_size(8 * WIDTH), may_alias));
typedef double Unaligned __attribute__((vector_size(8 * WIDTH), may_alias, aligned(8)));
typedef int64_t Bits __attribute__((vector_size(8 * WIDTH), may_alias));

#define magnitude NAMED(magnitude)
HELPER Numbers magnitude(Numbers x)
{
    return (Numbers)((Bits)x & INT64_MAX);
}

#define chosen NAMED(chosen)
HELPER Numbers chosen(Bits condition, Numbers x, Numbers y)
{
    return (Numbers)(((Bits)x & condition) | ((Bits)y & ~condition));
}

/* A comparison with NaN is false, so that NaN in y is chosen by itself. */
#define greater_of NAMED(greater_of)
HELPER Numbers greater_of(Numbers x, Numbers y)
{
    return chosen((Bits)(x > y) | (Bits)(x != x), x, y);
}

#define smaller_of NAMED(smaller_of)
HELPER Numbers smaller_of(Numbers x, Numbers y)
{
    return chosen((Bits)(x < y) | (Bits)(x != x), x, y);
}

#define square_root NAMED(square_root)
HELPER Numbers square_root(Numbers x)
{
    for (int l = 0; l < WIDTH; l++)
        x[l] = sqrt(x[l]);
    return x;
}

/* Sine and cosine of angles up to FARTHEST.

   x = k pi/2 + r + rest: products of k with the first two parts of pi/2 are exact, and so is what
   is left after the first; what rounding takes from r is kept in the rest. Both series end where
   their next term is below 2 % of rounding at |r| = pi/4. */
#define sine_cosine NAMED(sine_cosine)
HELPER void sine_cosine(Numbers x, Numbers *sine, Numbers *cosine)
{
    /* Of -0.0 too, the sine has the angle's sign. */
    Bits sign = (Bits)x & INT64_MIN;
    x = magnitude(x);
    /* The last bits of a number as large as this are units: k is rounded to nearest. */
    Numbers shifted = x * QUARTERS + UNITS, k = shifted - UNITS;
    Bits quarters = (Bits)shifted;

    Numbers left = x - k * QUARTER_1, part = k * QUARTER_2;
    Numbers coarse = left - part, lost = (left - coarse) - part;
    part = k * QUARTER_3;
    Numbers r = coarse - part, rest = ((coarse - r) - part) + lost;

    Numbers z = r * r;
    Numbers series = z * (-INVERSE_15 + z * INVERSE_17);
    series = z * (-INVERSE_11 + z * (INVERSE_13 + series));
    series = z * (-INVERSE_7 + z * (INVERSE_9 + series));
    series = z * (-INVERSE_3 + z * (INVERSE_5 + series));
    Numbers s = r + (r * series + rest * (1.0 - 0.5 * z));

    series = z * (-INVERSE_14 + z * INVERSE_16);
    series = z * (-INVERSE_10 + z * (INVERSE_12 + series));
    series = z * (-INVERSE_6 + z * (INVERSE_8 + series));
    series = z * z * (INVERSE_4 + series);
    Numbers half = 0.5 * z, c = 1.0 - half;
    c = c + (((1.0 - c) - half) + (series - r * rest));

    Bits is_odd = -(quarters & 1);
    *sine = (Numbers)((Bits)chosen(is_odd, c, s) ^ ((quarters & 2) << 62) ^ sign);
    *cosine = (Numbers)((Bits)chosen(is_odd, s, c) ^ (((quarters + 1) & 2) << 62));
}

/* The same for a block; angles beyond FARTHEST, and what is no number, by the library. */
#define sines_cosines NAMED(sines_cosines)
TARGET static void sines_cosines(const Numbers *angle, Numbers *sine, Numbers *cosine)
{
    Numbers x[VECTORS];
    Bits beyond = {0};
    for (int i = 0; i < VECTORS; i++) {
        x[i] = angle[i];
        beyond |= ~(Bits)(magnitude(x[i]) <= FARTHEST);
        sine_cosine(x[i], &sine[i], &cosine[i]);
    }
    int64_t any = 0;
    for (int l = 0; l < WIDTH; l++)
        any |= beyond[l];
    if (!any)
        return;
    EACH_LANE {
        double a = ((double *)x)[l];
        if (fabs(a) <= FARTHEST)
            continue;
        ((double *)sine)[l] = sin(a);
        ((double *)cosine)[l] = cos(a);
    }
}

/* Registers that are read, pa, pb ... up to one of six, and their vectors a, b ... */
#define REGISTER(operand) ((Numbers *)(registers + row[operand]))
#define NEXT \
    row += ROW; \
    goto *label[*row]

#define A const Numbers *pa = REGISTER(2)
#define B A, *pb = REGISTER(3)
#define C B, *pc = REGISTER(4)
#define D C, *pd = REGISTER(5)
#define E D, *pe = REGISTER(6)
#define F E, *pf = REGISTER(7)
#define AT_A Numbers a = pa[i]
#define AT_B AT_A, b = pb[i]
#define AT_C AT_B, c = pc[i]
#define AT_D AT_C, d = pd[i]
#define AT_E AT_D, e = pe[i]
#define AT_F AT_E, f = pf[i]
/* An operation that reads registers up to `LAST`. */
#define OPERATION(name, LAST, value) \
    name: { \
        Numbers *to = REGISTER(1); \
        LAST; \
        EACH_VECTOR { AT_##LAST; to[i] = value; } \
        NEXT; \
    }
#define BY_LIBRARY(name, LAST, value) \
    name: { \
        Numbers *to = REGISTER(1); \
        LAST; \
        EACH_LANE ((double *)to)[l] = value; \
        NEXT; \
    }
#define LANE_OF(vectors) ((const double *)vectors)[l]

OWN_JUMPS TARGET static void NAMED(run)(const int32_t *row, const double *constants,
                                        char *registers, const Input *inputs, double *outputs,
                                        Py_ssize_t lane)
{
#define LABEL(name, operands) &&name,
    static const void *const label[] = {EVERY_OPERATION(LABEL)};
#undef LABEL
    goto *label[*row];

    LOAD: {
        Numbers *to = REGISTER(1);
        const Input *input = &inputs[row[2]];
        const Unaligned *from = (const Unaligned *)(input->at + input->step * lane);
        EACH_VECTOR to[i] = from[i];
        NEXT;
    }
    STORE: {
        const Numbers *from = REGISTER(1);
        Numbers *to = (Numbers *)(outputs + (Py_ssize_t)row[2] * LANES);
        EACH_VECTOR to[i] = from[i];
        NEXT;
    }
    LDU: {
        double *to = (double *)REGISTER(1), value = *inputs[row[2]].at;
        EACH_LANE to[l] = value;
        NEXT;
    }
    KST: {
        double *to = (double *)REGISTER(1), value = constants[row[2]];
        EACH_LANE to[l] = value;
        NEXT;
    }
    SC: {
        Numbers unwanted[VECTORS];
        Numbers *sine = row[1] < 0 ? unwanted : REGISTER(1);
        Numbers *cosine = row[2] < 0 ? unwanted : REGISTER(2);
        sines_cosines(REGISTER(3), sine, cosine);
        NEXT;
    }
    OPERATION(ADD, B, a + b)
    OPERATION(SUB, B, a - b)
    OPERATION(MUL, B, a * b)
    OPERATION(DIV, B, a / b)
    OPERATION(RCP, A, 1.0 / a)
    OPERATION(NEG, A, -a)
    OPERATION(SQRT, A, square_root(a))
    OPERATION(ABS, A, magnitude(a))
    OPERATION(MAX, B, greater_of(a, b))
    OPERATION(MIN, B, smaller_of(a, b))
    OPERATION(SEL, C, chosen((Bits)(a > 0.0), b, c))
    OPERATION(FMA, C, a * b + c)
    OPERATION(FMS, C, a * b - c)
    OPERATION(FNMA, C, c - a * b)
    OPERATION(P2, D, a * b + c * d)
    OPERATION(M2, D, a * b - c * d)
    OPERATION(P3, F, a * b + c * d + e * f)
    OPERATION(A2, E, a + b * c + d * e)
    OPERATION(S2, E, a - b * c - d * e)
    OPERATION(AS, E, a + b * c - d * e)
    OPERATION(AMX, B, greater_of(a, magnitude(b)))
    OPERATION(ADD3, C, a + b + c)
    OPERATION(PPM, F, a * b + c * d - e * f)
    OPERATION(PMP, F, a * b - c * d + e * f)
    OPERATION(PMM, F, a * b - c * d - e * f)
    OPERATION(PMA, E, a * b - c * d + e)
    OPERATION(SA, E, a - b * c + d * e)
    BY_LIBRARY(EXP, A, exp(LANE_OF(pa)))
    BY_LIBRARY(LOG, A, log(LANE_OF(pa)))
    BY_LIBRARY(TANH, A, tanh(LANE_OF(pa)))
    BY_LIBRARY(ATAN2, B, atan2(LANE_OF(pa), LANE_OF(pb)))
    END:
    return;
}

TARGET static void NAMED(write)(double *to, Py_ssize_t apart, const double *rows, Py_ssize_t count,
                                int from, int streaming)
{
    for (; count > 0; count--, to += apart, rows += LANES) {
        const Numbers *row = (const Numbers *)rows;
        if (from > 0)
            memcpy(to + from, rows + from, sizeof(double) * (LANES - from));
        else if (streaming && (uintptr_t)to % sizeof(Numbers) == 0)
            EACH_VECTOR STREAM(to + i * WIDTH, row[i]);
        else
            EACH_VECTOR ((Unaligned *)to)[i] = row[i];
    }
}

static const Machine NAMED(machine) = {LANES, NAMED(run), NAMED(write)};

#undef VECTORS
#undef EACH_VECTOR
#undef EACH_LANE
#undef HELPER
#undef Numbers
#undef Unaligned
#undef Bits
#undef magnitude
#undef chosen
#undef greater_of
#undef smaller_of
#undef square_root
#undef sine_cosine
#undef sines_cosines
#undef REGISTER
#undef NEXT
#undef A
#undef B
#undef C
#undef D
#undef E
#undef F
#undef AT_A
#undef AT_B
#undef AT_C
#undef AT_D
#undef AT_E
#undef AT_F
#undef OPERATION
#undef BY_LIBRARY
#undef LANE_OF
#undef LANES
#undef NAMED
