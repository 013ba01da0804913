/* Values of the generated code as lanes: WIDTH doubles side by side (v_...), with masks that select without a branch.
 *
 * WIDTH is 4 where one trajectory runs (its times are computed side by side), else what the processor holds in one register.
 * Every function works on each lane by itself: what a lane gives does not depend on its neighbors. Sine and cosine: reduction by
 * pi/2 in two parts with fused multiply-add (Cody and Waite), kernels of FDLIBM (Sun Microsystems, k_sin.c and k_cos.c), below
 * 2 ulp; beyond 2^28 the C library's, lane by lane; exponential and logarithm likewise (below); all other functions the C library's. */
#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__) || (defined(__AVX2__) && defined(__FMA__))
#include <immintrin.h>
#endif
#ifdef SINGLE
#if defined(__AVX512F__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC target("prefer-vector-width=256") /* the short loops of one trajectory run slower in wider ones */
#endif
#define WIDTH 4
#elif defined(__AVX512F__)
#define WIDTH 8
#elif defined(__AVX__)
#define WIDTH 4
#else
#define WIDTH 2
#endif

typedef double V __attribute__((vector_size(8 * WIDTH)));
typedef int64_t v_mask __attribute__((vector_size(8 * WIDTH)));
/* -- lanes -- */
INLINE V v_all(double a) { return a - (V){0}; } /* keeps the sign of zero */
INLINE V v_where(v_mask m, V a) { return (V)(m & (v_mask)a); }
INLINE V v_select(v_mask m, V a, V b) { return (V)((m & (v_mask)a) | (~m & (v_mask)b)); }
INLINE V v_number(v_mask m) { return v_where(m, v_all(1.0)); }
INLINE v_mask v_not(v_mask m) { return ~m; }
INLINE v_mask v_and(v_mask a, v_mask b) { return a & b; }
INLINE v_mask v_or(v_mask a, v_mask b) { return a | b; }
INLINE V v_sign(V a) { return v_select(a == a, v_select(a == 0.0, a, v_number(a > 0.0) - v_number(a < 0.0)), a); }
INLINE V v_fmin(V a, V b) { return v_select((a < b) | (b != b), a, b); }
INLINE V v_fmax(V a, V b) { return v_select((a > b) | (b != b), a, b); }
INLINE V v_fabs(V a) { return (V)((v_mask)a & INT64_MAX); }
#define V_ONE(name) INLINE V v_##name(V a) { V r; for (int i = 0; i < WIDTH; ++i) r[i] = name(a[i]); return r; }
#define V_TWO(name) INLINE V v_##name(V a, V b) { V r; for (int i = 0; i < WIDTH; ++i) r[i] = name(a[i], b[i]); return r; }

#if WIDTH == 8 && defined(__AVX512F__)
INLINE V v_fma(V a, V b, V c) { return (V)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c); }
INLINE V v_larger(V a, V b) { return (V)_mm512_max_pd((__m512d)a, (__m512d)b); } /* b where one is NaN */
INLINE V v_sqrt(V a) { return (V)_mm512_sqrt_pd((__m512d)a); }
INLINE V v_floor(V a) { return (V)_mm512_roundscale_pd((__m512d)a, 1); }
INLINE V v_ceil(V a) { return (V)_mm512_roundscale_pd((__m512d)a, 2); }
INLINE int v_any(v_mask m) { return _mm512_test_epi64_mask((__m512i)m, (__m512i)m) != 0; }
#elif WIDTH == 4 && defined(__AVX2__) && defined(__FMA__)
INLINE V v_fma(V a, V b, V c) { return (V)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }
INLINE V v_larger(V a, V b) { return (V)_mm256_max_pd((__m256d)a, (__m256d)b); }
INLINE V v_sqrt(V a) { return (V)_mm256_sqrt_pd((__m256d)a); }
INLINE V v_floor(V a) { return (V)_mm256_floor_pd((__m256d)a); }
INLINE V v_ceil(V a) { return (V)_mm256_ceil_pd((__m256d)a); }
INLINE int v_any(v_mask m) { return !_mm256_testz_si256((__m256i)m, (__m256i)m); }
#else
INLINE V v_fma(V a, V b, V c) { V r; for (int i = 0; i < WIDTH; ++i) r[i] = fma(a[i], b[i], c[i]); return r; }
INLINE V v_larger(V a, V b) { return v_select(a > b, a, b); }
V_ONE(sqrt) V_ONE(floor) V_ONE(ceil)
INLINE int v_any(v_mask m) { int64_t found = 0; for (int i = 0; i < WIDTH; ++i) found |= m[i]; return found != 0; }
#endif

V_ONE(tan) V_ONE(asin) V_ONE(acos) V_ONE(atan) V_ONE(sinh) V_ONE(cosh) V_ONE(tanh)
V_ONE(asinh) V_ONE(acosh) V_ONE(atanh) V_ONE(erf) V_ONE(log1p) V_ONE(expm1)
V_TWO(pow) V_TWO(atan2) V_TWO(fmod) V_TWO(copysign) V_TWO(hypot) V_TWO(remainder)

/* Exponential: by powers of two and Taylor's polynomial on what is left (below 0.35); beyond 700, the C library's. */
static __attribute__((unused)) V v_exp(V a) {
  const double shift = 6755399441055744.0; /* 1.5 * 2^52: adding it rounds to a whole number, found in the lowest bits */
  V shifted = v_fma(a, v_all(1.44269504088896338700e+00), v_all(shift)), turns = shifted - shift;
  V r = v_fma(-turns, v_all(6.93147180369123816490e-01), a);
  r = v_fma(-turns, v_all(1.90821492927058770002e-10), r);
  V s = v_all(1.0 / 6227020800);
  s = v_fma(r, s, v_all(1.0 / 479001600));
  s = v_fma(r, s, v_all(1.0 / 39916800));
  s = v_fma(r, s, v_all(1.0 / 3628800));
  s = v_fma(r, s, v_all(1.0 / 362880));
  s = v_fma(r, s, v_all(1.0 / 40320));
  s = v_fma(r, s, v_all(1.0 / 5040));
  s = v_fma(r, s, v_all(1.0 / 720));
  s = v_fma(r, s, v_all(1.0 / 120));
  s = v_fma(r, s, v_all(1.0 / 24));
  s = v_fma(r, s, v_all(1.0 / 6));
  s = v_fma(r, s, v_all(0.5));
  s = v_fma(r * r, s, r) + 1.0;
  V found = s * (V)(((v_mask)shifted << 52) + 0x3ff0000000000000);
  v_mask far = ~(v_fabs(a) < 700.0);
  if (v_any(far))
    for (int i = 0; i < WIDTH; ++i)
      if (far[i]) found[i] = exp(a[i]);
  return found;
}

/* Natural logarithm: reduction to half an octave around 1 and the kernel of FDLIBM (Sun Microsystems, e_log.c), below 1 ulp; the C library's
 * for what is not a positive normal number. */
static __attribute__((unused)) V v_log(V a) {
  v_mask bits = (v_mask)a, up = (bits & 0xfffffffffffff) + 0x95f64ffffffff; /* carries into the exponent from the root of two on */
  v_mask power = (bits >> 52) - 1023 + (up >> 52);
  V m = (V)(bits - (power << 52)), whole = __builtin_convertvector(power, V);
  V f = m - 1.0, s = f / (2.0 + f), z = s * s, w = z * z, half = 0.5 * f * f;
  V one = w * v_fma(w, v_fma(w, v_all(1.531383769920937332e-01), v_all(2.222219843214978396e-01)), v_all(3.999999999940941908e-01));
  V two = v_fma(w, v_fma(w, v_all(1.479819860511658591e-01), v_all(1.818357216161805012e-01)), v_all(2.857142874366239149e-01));
  two = z * v_fma(w, two, v_all(6.666666666666735130e-01));
  V found = whole * 6.93147180369123816490e-01 - ((half - v_fma(s, half + (one + two), whole * 1.90821492927058770002e-10)) - f);
  v_mask odd = ~((a >= 2.2250738585072014e-308) & (a <= 1.7976931348623157e308));
  if (v_any(odd))
    for (int i = 0; i < WIDTH; ++i)
      if (odd[i]) found[i] = log(a[i]);
  return found;
}

/* Sine and cosine of angle + rest, where |rest| is of the order of the rounding of the angle. */
static __attribute__((unused)) void v_sine_cosine(V angle, V rest, V *sine, V *cosine) {
  const double shift = 6755399441055744.0; /* 1.5 * 2^52: adding it rounds to a whole number, found in the lowest bits */
  V shifted = v_fma(angle, v_all(6.36619772367581382433e-01), v_all(shift));
  V turns = shifted - shift;
  v_mask quadrant = (v_mask)shifted;
  V near = v_fma(-turns, v_all(1.57079632679489655800e+00), angle);
  V r = near + v_fma(-turns, v_all(6.12323399573676603587e-17), rest);
  V z = r * r;
  V s = v_fma(z, v_all(1.58969099521155010221e-10), v_all(-2.50507602534068634195e-08));
  s = v_fma(z, s, v_all(2.75573137070700676789e-06));
  s = v_fma(z, s, v_all(-1.98412698298579493134e-04));
  s = v_fma(z, s, v_all(8.33333333332248946124e-03));
  s = v_fma(z, s, v_all(-1.66666666666666324348e-01));
  s = v_fma(z * r, s, r);
  V c = v_fma(z, v_all(-1.13596475577881948265e-11), v_all(2.08757232129817482790e-09));
  c = v_fma(z, c, v_all(-2.75573143513906633035e-07));
  c = v_fma(z, c, v_all(2.48015872894767294178e-05));
  c = v_fma(z, c, v_all(-1.38888888888741095749e-03));
  c = v_fma(z, c, v_all(4.16666666666666019037e-02));
  V half = 0.5 * z, most = 1.0 - half;
  c = most + ((1.0 - most) - half + z * z * c);
  v_mask swapped = (quadrant & 1) != 0;
  v_mask sine_sign = (quadrant & 2) << 62, cosine_sign = ((quadrant + 1) & 2) << 62;
  V a = (V)((v_mask)v_select(swapped, c, s) ^ sine_sign), b = (V)((v_mask)v_select(swapped, s, c) ^ cosine_sign);
  v_mask far = ~(v_fabs(angle) < 268435456.0);
  if (v_any(far))
    for (int i = 0; i < WIDTH; ++i)
      if (far[i]) {
        double sine_of = sin(angle[i]), cosine_of = cos(angle[i]);
        a[i] = sine_of + rest[i] * cosine_of, b[i] = cosine_of - rest[i] * sine_of;
      }
  *sine = a, *cosine = b;
}
INLINE V v_sin(V a) { V s, c; v_sine_cosine(a, v_all(0.0), &s, &c); return s; }
INLINE V v_cos(V a) { V s, c; v_sine_cosine(a, v_all(0.0), &s, &c); return c; }

/* Sine and cosine of frequency times t with every digit of the product: its rounding error is the rest. */
INLINE void v_clock(V frequency, V t, V *sine, V *cosine) {
  V angle = frequency * t;
  v_sine_cosine(angle, v_fma(frequency, t, -angle), sine, cosine);
}

/* The same at t + rest, where |rest| is of the order of the rounding of t. */
INLINE void v_clock_between(V frequency, V t, V rest, V *sine, V *cosine) {
  V angle = frequency * t;
  v_sine_cosine(angle, v_fma(frequency, t, -angle) + frequency * rest, sine, cosine);
}
