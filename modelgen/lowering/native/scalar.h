/* Values of the generated code as one double (s_...). C99, also C++; needs nothing but libm; no global, no allocation. */
#include <math.h>

typedef int s_mask;
#if defined(__GNUC__)
#define INLINE static inline __attribute__((unused, always_inline))
#else
#define INLINE static inline
#endif
INLINE double s_all(double a) { return a; }
INLINE double s_number(s_mask m) { return m ? 1.0 : 0.0; }
INLINE double s_where(s_mask m, double a) { return m ? a : 0.0; }
INLINE double s_select(s_mask m, double a, double b) { return m ? a : b; }
INLINE s_mask s_not(s_mask m) { return !m; }
INLINE s_mask s_and(s_mask a, s_mask b) { return a && b; }
INLINE s_mask s_or(s_mask a, s_mask b) { return a || b; }
INLINE double s_sign(double a) { return a < 0 ? -1.0 : a > 0 ? 1.0 : a; }
INLINE double s_fmin(double a, double b) { return a < b || b != b ? a : b; }
INLINE double s_fmax(double a, double b) { return a > b || b != b ? a : b; }
#define S_ONE(name) INLINE double s_##name(double a) { return name(a); }
#define S_TWO(name) INLINE double s_##name(double a, double b) { return name(a, b); }
S_ONE(sqrt) S_ONE(floor) S_ONE(ceil) S_ONE(fabs) S_ONE(sin) S_ONE(cos) S_ONE(exp) S_ONE(log) S_ONE(tan)
S_ONE(asin) S_ONE(acos) S_ONE(atan) S_ONE(sinh) S_ONE(cosh) S_ONE(tanh) S_ONE(asinh) S_ONE(acosh) S_ONE(atanh)
S_ONE(erf) S_ONE(log1p) S_ONE(expm1)
S_TWO(pow) S_TWO(atan2) S_TWO(fmod) S_TWO(copysign) S_TWO(hypot) S_TWO(remainder)

/* Sine and cosine of frequency times t with every digit of the product: its rounding error is the rest. */
INLINE void s_clock(double frequency, double t, double *sine, double *cosine) {
  double angle = frequency * t, rest = fma(frequency, t, -angle), s = sin(angle), c = cos(angle);
  *sine = s + rest * c, *cosine = c - rest * s;
}
