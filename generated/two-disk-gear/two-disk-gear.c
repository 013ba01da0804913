/* two-disk-gear: the equations as C functions, their tables of names, and a Runge-Kutta solver; see two-disk-gear.h. Written by modelgen.
 *
 * A right-hand side falls into what depends on parameters only (two_disk_gear_prepare), on time only (..._at) and on the state (..._of).
 * x, p and the outputs are numbered as in the tables at the end of the equations. */
#include "two-disk-gear.h"

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

#define C(i) c[i]
#define W(i) w[i]
void two_disk_gear_prepare(const double *p, double *c) {
  (void)p, (void)c;
  const double a13 = s_cos(p[21]);
  const double a14 = p[19] * a13;
  const double a19 = p[21] + p[21];
  const double a20 = s_cos(a19);
  const double a21 = p[20] * a20;
  const double a22 = -a21;
  const double a23 = s_sin(p[21]);
  const double a24 = p[19] * a23;
  const double a25 = -a24;
  const double a28 = s_sin(a19);
  const double a29 = p[20] * a28;
  const double a30 = s_all(2.0) * a29;
  const double a31 = -a30;
  const double a32 = p[22] * p[2];
  const double a33 = p[22] * a14;
  const double a34 = p[22] * a21;
  const double a35 = p[22] * a22;
  const double a36 = p[22] * a25;
  const double a37 = p[22] * a31;
  const double a49 = p[0] * p[5];
  const double a51 = a49 * p[16];
  const double a55 = s_cos(p[17]);
  const double a57 = s_sin(p[17]);
  const double a58 = -a57;
  const double a59 = a51 * a55;
  const double a60 = a51 * a58;
  const double a66 = p[1] + p[1];
  const double a68 = s_sqrt(p[3]);
  const double a69 = a66 * a68;
  const double a71 = s_sqrt(p[4]);
  const double a72 = a69 * a71;
  const double a95 = -p[36];
  const double a106 = -p[32];
  const double a112 = -p[33];
  const double a116 = -p[34];
  const double a120 = -p[35];
  const double a124 = s_all(2.0) * p[46];
  const double a131 = s_all(2.0) * p[42];
  const double a137 = s_all(2.0) * p[44];
  const double a175 = s_all(2.0) * p[38];
  const double a180 = s_all(2.0) * p[40];
  const double a199 = s_all(0.5) * p[7];
  const double a201 = a199 * p[6];
  const double a203 = s_cos(p[8]);
  const double a204 = a201 * a203;
  const double a205 = a204 * a204;
  const double a206 = p[3] * a205;
  const double a207 = p[5] * a199;
  const double a208 = a203 * a207;
  const double a209 = a208 * a208;
  const double a210 = p[4] * a209;
  const double a211 = a206 + a210;
  const double a212 = s_all(1.0) / a211;
  const double a219 = p[16] * a57;
  const double a220 = p[16] * a55;
  const double a241 = s_all(1.0) / p[3];
  const double a243 = a208 * a241;
  const double a246 = p[7] * s_all((-0.5));
  const double a247 = p[6] * a246;
  const double a248 = a203 * a247;
  const double a252 = p[23] * p[25];
  const double a254 = s_all(1.0) / p[4];
  const double a256 = a248 * a254;
  const double a262 = p[5] / p[6];
  const double a263 = p[4] * a262;
  const double a266 = s_all(1.0) / a248;
  const double a268 = a263 * a266;
  const double a271 = a262 * a263;
  const double a272 = p[3] + a271;
  const double a273 = s_all(1.0) / a272;
  const double a277 = p[0] * a262;
  const double a280 = a262 * a273;
  const double a298 = s_all(1.0) / s_all(2.0);
  const double a310 = a204 * a254;
  const double a311 = a248 * a310;
  const double a314 = a208 * a243;
  const double a318 = a72 * a208;
  const double a319 = a241 * a318;
  const double a320 = -a319;
  const double a322 = a72 * a204;
  const double a323 = a254 * a322;
  const double a324 = a248 * a323;
  const double a325 = a208 * a319;
  const double a326 = -a325;
  const double a327 = a324 + a326;
  c[0] = p[0];
  c[1] = a32;
  c[2] = a33;
  c[3] = a34;
  c[4] = a35;
  c[5] = a36;
  c[6] = a37;
  c[7] = a49;
  c[8] = a59;
  c[9] = a60;
  c[10] = p[3];
  c[11] = p[4];
  c[12] = a72;
  c[13] = p[26];
  c[14] = p[27];
  c[15] = p[36];
  c[16] = a95;
  c[17] = p[28];
  c[18] = p[29];
  c[19] = p[30];
  c[20] = p[31];
  c[21] = p[32];
  c[22] = a106;
  c[23] = p[33];
  c[24] = a112;
  c[25] = p[34];
  c[26] = a116;
  c[27] = p[35];
  c[28] = a120;
  c[29] = p[37];
  c[30] = a124;
  c[31] = p[39];
  c[32] = p[41];
  c[33] = a131;
  c[34] = p[43];
  c[35] = a137;
  c[36] = p[45];
  c[37] = a175;
  c[38] = a180;
  c[39] = a204;
  c[40] = a208;
  c[41] = a212;
  c[42] = p[15];
  c[43] = a219;
  c[44] = a220;
  c[45] = p[18];
  c[46] = a241;
  c[47] = a243;
  c[48] = a252;
  c[49] = a254;
  c[50] = a256;
  c[51] = a266;
  c[52] = a268;
  c[53] = a273;
  c[54] = a277;
  c[55] = a280;
  c[56] = a298;
  c[57] = a311;
  c[58] = a314;
  c[59] = a320;
  c[60] = a327;
}

static void rates_at(const double *c, double t, double *w) {
  (void)c, (void)t, (void)w;
  double sine_a10, cosine_a10;
  s_clock(C(0), t, &sine_a10, &cosine_a10);
  const double a10 = cosine_a10;
  const double a15 = a10 * a10;
  const double a16 = sine_a10;
  const double a17 = a16 * a16;
  const double a26 = a10 * a16;
  const double a38 = a10 * C(2);
  const double a39 = C(1) + a38;
  const double a40 = a15 * C(3);
  const double a41 = a39 + a40;
  const double a42 = a17 * C(4);
  const double a43 = a41 + a42;
  const double a44 = a16 * C(5);
  const double a45 = a43 + a44;
  const double a46 = a26 * C(6);
  const double a47 = a45 + a46;
  double sine_a53, cosine_a53;
  s_clock(C(7), t, &sine_a53, &cosine_a53);
  const double a53 = cosine_a53;
  const double a56 = sine_a53;
  const double a61 = a53 * C(8);
  const double a62 = a56 * C(9);
  const double a63 = a61 + a62;
  const double a75 = a53 * a53;
  const double a76 = a56 * a56;
  const double a77 = a75 - a76;
  const double a78 = a53 * a77;
  const double a79 = a53 * a56;
  const double a80 = s_all(2.0) * a79;
  const double a81 = a56 * a80;
  const double a82 = a78 - a81;
  const double a83 = a77 * a82;
  const double a84 = a56 * a77;
  const double a85 = a53 * a80;
  const double a86 = a84 + a85;
  const double a87 = a80 * a86;
  const double a88 = a83 - a87;
  const double a89 = a88 * a88;
  const double a90 = a80 * a82;
  const double a91 = a77 * a86;
  const double a92 = a90 + a91;
  const double a93 = a92 * a92;
  const double a98 = a77 * a77;
  const double a99 = a80 * a80;
  const double a100 = a98 - a99;
  const double a103 = a82 * a82;
  const double a104 = a86 * a86;
  const double a107 = a82 * a100;
  const double a108 = a77 * a80;
  const double a109 = s_all(2.0) * a108;
  const double a110 = a86 * a109;
  const double a113 = a100 * a100;
  const double a114 = a109 * a109;
  const double a117 = a88 * a100;
  const double a118 = a92 * a109;
  const double a122 = a88 * a92;
  const double a129 = a82 * a86;
  const double a132 = a86 * a100;
  const double a133 = a82 * a109;
  const double a135 = a100 * a109;
  const double a138 = a88 * a109;
  const double a139 = a92 * a100;
  const double a141 = a53 * C(14);
  const double a142 = C(13) + a141;
  const double a143 = a89 * C(15);
  const double a144 = a142 + a143;
  const double a145 = a93 * C(16);
  const double a146 = a144 + a145;
  const double a147 = a77 * C(17);
  const double a148 = a146 + a147;
  const double a149 = a82 * C(18);
  const double a150 = a148 + a149;
  const double a151 = a100 * C(19);
  const double a152 = a150 + a151;
  const double a153 = a88 * C(20);
  const double a154 = a152 + a153;
  const double a155 = a103 * C(21);
  const double a156 = a154 + a155;
  const double a157 = a104 * C(22);
  const double a158 = a156 + a157;
  const double a159 = a107 * C(23);
  const double a160 = a158 + a159;
  const double a161 = a110 * C(24);
  const double a162 = a160 + a161;
  const double a163 = a113 * C(25);
  const double a164 = a162 + a163;
  const double a165 = a114 * C(26);
  const double a166 = a164 + a165;
  const double a167 = a117 * C(27);
  const double a168 = a166 + a167;
  const double a169 = a118 * C(28);
  const double a170 = a168 + a169;
  const double a171 = a56 * C(29);
  const double a172 = a170 + a171;
  const double a173 = a122 * C(30);
  const double a174 = a172 + a173;
  const double a176 = a79 * C(37);
  const double a177 = a174 + a176;
  const double a178 = a86 * C(31);
  const double a179 = a177 + a178;
  const double a181 = a108 * C(38);
  const double a182 = a179 + a181;
  const double a183 = a92 * C(32);
  const double a184 = a182 + a183;
  const double a185 = a129 * C(33);
  const double a186 = a184 + a185;
  const double a187 = a132 * C(34);
  const double a188 = a186 + a187;
  const double a189 = a133 * C(34);
  const double a190 = a188 + a189;
  const double a191 = a135 * C(35);
  const double a192 = a190 + a191;
  const double a193 = a138 * C(36);
  const double a194 = a192 + a193;
  const double a195 = a139 * C(36);
  const double a196 = a194 + a195;
  const double a213 = a196 * C(41);
  const double a214 = s_sqrt(a213);
  const double a215 = C(12) * a214;
  const double a221 = a53 * C(43);
  const double a222 = C(42) + a221;
  const double a223 = a56 * C(44);
  const double a224 = a222 + a223;
  w[1] = a47;
  w[2] = a63;
  w[3] = a196;
  w[4] = a215;
  w[5] = a224;
}
static void rates_of(const double *c, const double *w, const double *x, double *rates) {
  (void)c, (void)w, (void)x;
  const double a64 = x[3] - W(2);
  const double a216 = a64 * W(4);
  const double a225 = x[1] - W(5);
  const double a227 = a225 - C(45);
  const s_mask a228 = s_all(0.0) <= a227;
  const double a229 = s_all(1.0) - s_number(a228);
  const double a230 = a225 + C(45);
  const double a231 = -a230;
  const s_mask a232 = s_all(0.0) <= a231;
  const double a233 = a229 * s_number(a232);
  const double a234 = a230 * a233;
  const double a235 = a227 * s_number(a228);
  const double a236 = a234 + a235;
  const double a237 = W(3) * a236;
  const double a238 = a216 + a237;
  const double a239 = C(40) * a238;
  const double a240 = W(1) - a239;
  const double a242 = a240 * C(46);
  const double a244 = a240 * C(47);
  const double a249 = C(39) * a238;
  const double a253 = a249 + C(48);
  const double a257 = a253 * C(50);
  const double a258 = a244 + a257;
  rates[0] = x[2];
  rates[1] = x[3];
  rates[2] = a242;
  rates[3] = a258;
}
void two_disk_gear_rates(const double *c, double t, const double *x, double *rates) {
  double w[two_disk_gear_W];
  rates_at(c, t, w);
  rates_of(c, w, x, rates);
}

static void outputs_at(const double *c, double t, double *w) {
  (void)c, (void)t, (void)w;
  const double a9 = C(0) * t;
  double sine_a10, cosine_a10;
  s_clock(C(0), t, &sine_a10, &cosine_a10);
  const double a10 = cosine_a10;
  const double a15 = a10 * a10;
  const double a16 = sine_a10;
  const double a17 = a16 * a16;
  const double a26 = a10 * a16;
  const double a38 = a10 * C(2);
  const double a39 = C(1) + a38;
  const double a40 = a15 * C(3);
  const double a41 = a39 + a40;
  const double a42 = a17 * C(4);
  const double a43 = a41 + a42;
  const double a44 = a16 * C(5);
  const double a45 = a43 + a44;
  const double a46 = a26 * C(6);
  const double a47 = a45 + a46;
  double sine_a53, cosine_a53;
  s_clock(C(7), t, &sine_a53, &cosine_a53);
  const double a53 = cosine_a53;
  const double a56 = sine_a53;
  const double a61 = a53 * C(8);
  const double a62 = a56 * C(9);
  const double a63 = a61 + a62;
  const double a75 = a53 * a53;
  const double a76 = a56 * a56;
  const double a77 = a75 - a76;
  const double a78 = a53 * a77;
  const double a79 = a53 * a56;
  const double a80 = s_all(2.0) * a79;
  const double a81 = a56 * a80;
  const double a82 = a78 - a81;
  const double a83 = a77 * a82;
  const double a84 = a56 * a77;
  const double a85 = a53 * a80;
  const double a86 = a84 + a85;
  const double a87 = a80 * a86;
  const double a88 = a83 - a87;
  const double a89 = a88 * a88;
  const double a90 = a80 * a82;
  const double a91 = a77 * a86;
  const double a92 = a90 + a91;
  const double a93 = a92 * a92;
  const double a98 = a77 * a77;
  const double a99 = a80 * a80;
  const double a100 = a98 - a99;
  const double a103 = a82 * a82;
  const double a104 = a86 * a86;
  const double a107 = a82 * a100;
  const double a108 = a77 * a80;
  const double a109 = s_all(2.0) * a108;
  const double a110 = a86 * a109;
  const double a113 = a100 * a100;
  const double a114 = a109 * a109;
  const double a117 = a88 * a100;
  const double a118 = a92 * a109;
  const double a122 = a88 * a92;
  const double a129 = a82 * a86;
  const double a132 = a86 * a100;
  const double a133 = a82 * a109;
  const double a135 = a100 * a109;
  const double a138 = a88 * a109;
  const double a139 = a92 * a100;
  const double a141 = a53 * C(14);
  const double a142 = C(13) + a141;
  const double a143 = a89 * C(15);
  const double a144 = a142 + a143;
  const double a145 = a93 * C(16);
  const double a146 = a144 + a145;
  const double a147 = a77 * C(17);
  const double a148 = a146 + a147;
  const double a149 = a82 * C(18);
  const double a150 = a148 + a149;
  const double a151 = a100 * C(19);
  const double a152 = a150 + a151;
  const double a153 = a88 * C(20);
  const double a154 = a152 + a153;
  const double a155 = a103 * C(21);
  const double a156 = a154 + a155;
  const double a157 = a104 * C(22);
  const double a158 = a156 + a157;
  const double a159 = a107 * C(23);
  const double a160 = a158 + a159;
  const double a161 = a110 * C(24);
  const double a162 = a160 + a161;
  const double a163 = a113 * C(25);
  const double a164 = a162 + a163;
  const double a165 = a114 * C(26);
  const double a166 = a164 + a165;
  const double a167 = a117 * C(27);
  const double a168 = a166 + a167;
  const double a169 = a118 * C(28);
  const double a170 = a168 + a169;
  const double a171 = a56 * C(29);
  const double a172 = a170 + a171;
  const double a173 = a122 * C(30);
  const double a174 = a172 + a173;
  const double a176 = a79 * C(37);
  const double a177 = a174 + a176;
  const double a178 = a86 * C(31);
  const double a179 = a177 + a178;
  const double a181 = a108 * C(38);
  const double a182 = a179 + a181;
  const double a183 = a92 * C(32);
  const double a184 = a182 + a183;
  const double a185 = a129 * C(33);
  const double a186 = a184 + a185;
  const double a187 = a132 * C(34);
  const double a188 = a186 + a187;
  const double a189 = a133 * C(34);
  const double a190 = a188 + a189;
  const double a191 = a135 * C(35);
  const double a192 = a190 + a191;
  const double a193 = a138 * C(36);
  const double a194 = a192 + a193;
  const double a195 = a139 * C(36);
  const double a196 = a194 + a195;
  const double a213 = a196 * C(41);
  const double a214 = s_sqrt(a213);
  const double a215 = C(12) * a214;
  const double a221 = a53 * C(43);
  const double a222 = C(42) + a221;
  const double a223 = a56 * C(44);
  const double a224 = a222 + a223;
  const double a278 = t * C(54);
  const double a289 = a196 * s_all(0.5);
  const double a301 = a63 * a215;
  w[0] = a9;
  w[1] = a47;
  w[2] = a63;
  w[3] = a196;
  w[4] = a215;
  w[5] = a224;
  w[6] = a278;
  w[7] = a289;
  w[8] = a301;
}
static void outputs_of(const double *c, const double *w, const double *x, double *outputs) {
  (void)c, (void)w, (void)x;
  const double a64 = x[3] - W(2);
  const double a216 = a64 * W(4);
  const double a225 = x[1] - W(5);
  const double a227 = a225 - C(45);
  const s_mask a228 = s_all(0.0) <= a227;
  const double a229 = s_all(1.0) - s_number(a228);
  const double a230 = a225 + C(45);
  const double a231 = -a230;
  const s_mask a232 = s_all(0.0) <= a231;
  const double a233 = a229 * s_number(a232);
  const double a234 = a230 * a233;
  const double a235 = a227 * s_number(a228);
  const double a236 = a234 + a235;
  const double a237 = W(3) * a236;
  const double a238 = a216 + a237;
  const double a239 = C(40) * a238;
  const double a240 = W(1) - a239;
  const double a242 = a240 * C(46);
  const double a249 = C(39) * a238;
  const double a253 = a249 + C(48);
  const double a255 = a253 * C(49);
  const double a260 = W(0) + x[0];
  const double a261 = C(10) * x[0];
  const double a264 = C(40) * x[0];
  const double a265 = x[1] - a264;
  const double a267 = a265 * C(51);
  const double a269 = a265 * C(52);
  const double a270 = a261 + a269;
  const double a274 = a270 * C(53);
  const double a275 = x[0] - a274;
  const double a276 = x[2] + C(0);
  const double a279 = a267 + W(6);
  const double a281 = a270 * C(55);
  const double a282 = a267 - a281;
  const double a283 = x[2] * C(40);
  const double a284 = x[3] - a283;
  const double a285 = C(51) * a284;
  const double a286 = C(54) + a285;
  const double a287 = a233 + a233;
  const double a288 = s_number(a228) + a287;
  const double a290 = a236 * a236;
  const double a291 = W(7) * a290;
  const double a292 = a64 * a216;
  const double a293 = C(10) * a276;
  const double a294 = a276 * a293;
  const double a295 = C(11) * a286;
  const double a296 = a286 * a295;
  const double a297 = a294 + a296;
  const double a299 = a297 * C(56);
  const double a300 = W(1) * a276;
  const double a302 = a64 * W(8);
  const double a303 = a300 - a302;
  const double a304 = C(48) * a286;
  const double a305 = a303 + a304;
  outputs[0] = a260;
  outputs[1] = x[0];
  outputs[2] = a275;
  outputs[3] = a276;
  outputs[4] = a242;
  outputs[5] = a279;
  outputs[6] = a267;
  outputs[7] = a282;
  outputs[8] = a286;
  outputs[9] = a255;
  outputs[10] = C(40);
  outputs[11] = C(39);
  outputs[12] = W(3);
  outputs[13] = W(5);
  outputs[14] = W(2);
  outputs[15] = W(4);
  outputs[16] = x[1];
  outputs[17] = a64;
  outputs[18] = a225;
  outputs[19] = a236;
  outputs[20] = a238;
  outputs[21] = a288;
  outputs[22] = a291;
  outputs[23] = a292;
  outputs[24] = W(1);
  outputs[25] = C(48);
  outputs[26] = a299;
  outputs[27] = a291;
  outputs[28] = a292;
  outputs[29] = a305;
}
void two_disk_gear_outputs(const double *c, double t, const double *x, double *outputs) {
  double w[two_disk_gear_W];
  outputs_at(c, t, w);
  outputs_of(c, w, x, outputs);
}

static void jacobian_at(const double *c, double t, double *w) {
  (void)c, (void)t, (void)w;
  double sine_a53, cosine_a53;
  s_clock(C(7), t, &sine_a53, &cosine_a53);
  const double a53 = cosine_a53;
  const double a56 = sine_a53;
  const double a75 = a53 * a53;
  const double a76 = a56 * a56;
  const double a77 = a75 - a76;
  const double a78 = a53 * a77;
  const double a79 = a53 * a56;
  const double a80 = s_all(2.0) * a79;
  const double a81 = a56 * a80;
  const double a82 = a78 - a81;
  const double a83 = a77 * a82;
  const double a84 = a56 * a77;
  const double a85 = a53 * a80;
  const double a86 = a84 + a85;
  const double a87 = a80 * a86;
  const double a88 = a83 - a87;
  const double a89 = a88 * a88;
  const double a90 = a80 * a82;
  const double a91 = a77 * a86;
  const double a92 = a90 + a91;
  const double a93 = a92 * a92;
  const double a98 = a77 * a77;
  const double a99 = a80 * a80;
  const double a100 = a98 - a99;
  const double a103 = a82 * a82;
  const double a104 = a86 * a86;
  const double a107 = a82 * a100;
  const double a108 = a77 * a80;
  const double a109 = s_all(2.0) * a108;
  const double a110 = a86 * a109;
  const double a113 = a100 * a100;
  const double a114 = a109 * a109;
  const double a117 = a88 * a100;
  const double a118 = a92 * a109;
  const double a122 = a88 * a92;
  const double a129 = a82 * a86;
  const double a132 = a86 * a100;
  const double a133 = a82 * a109;
  const double a135 = a100 * a109;
  const double a138 = a88 * a109;
  const double a139 = a92 * a100;
  const double a141 = a53 * C(14);
  const double a142 = C(13) + a141;
  const double a143 = a89 * C(15);
  const double a144 = a142 + a143;
  const double a145 = a93 * C(16);
  const double a146 = a144 + a145;
  const double a147 = a77 * C(17);
  const double a148 = a146 + a147;
  const double a149 = a82 * C(18);
  const double a150 = a148 + a149;
  const double a151 = a100 * C(19);
  const double a152 = a150 + a151;
  const double a153 = a88 * C(20);
  const double a154 = a152 + a153;
  const double a155 = a103 * C(21);
  const double a156 = a154 + a155;
  const double a157 = a104 * C(22);
  const double a158 = a156 + a157;
  const double a159 = a107 * C(23);
  const double a160 = a158 + a159;
  const double a161 = a110 * C(24);
  const double a162 = a160 + a161;
  const double a163 = a113 * C(25);
  const double a164 = a162 + a163;
  const double a165 = a114 * C(26);
  const double a166 = a164 + a165;
  const double a167 = a117 * C(27);
  const double a168 = a166 + a167;
  const double a169 = a118 * C(28);
  const double a170 = a168 + a169;
  const double a171 = a56 * C(29);
  const double a172 = a170 + a171;
  const double a173 = a122 * C(30);
  const double a174 = a172 + a173;
  const double a176 = a79 * C(37);
  const double a177 = a174 + a176;
  const double a178 = a86 * C(31);
  const double a179 = a177 + a178;
  const double a181 = a108 * C(38);
  const double a182 = a179 + a181;
  const double a183 = a92 * C(32);
  const double a184 = a182 + a183;
  const double a185 = a129 * C(33);
  const double a186 = a184 + a185;
  const double a187 = a132 * C(34);
  const double a188 = a186 + a187;
  const double a189 = a133 * C(34);
  const double a190 = a188 + a189;
  const double a191 = a135 * C(35);
  const double a192 = a190 + a191;
  const double a193 = a138 * C(36);
  const double a194 = a192 + a193;
  const double a195 = a139 * C(36);
  const double a196 = a194 + a195;
  const double a213 = a196 * C(41);
  const double a214 = s_sqrt(a213);
  const double a221 = a53 * C(43);
  const double a222 = C(42) + a221;
  const double a223 = a56 * C(44);
  const double a224 = a222 + a223;
  const double a307 = a196 * C(47);
  const double a312 = a196 * C(57);
  const double a315 = a196 * C(58);
  const double a321 = a214 * C(59);
  const double a328 = a214 * C(60);
  w[3] = a196;
  w[5] = a224;
  w[9] = a307;
  w[10] = a312;
  w[11] = a315;
  w[12] = a321;
  w[13] = a328;
}
static void jacobian_of(const double *c, const double *w, const double *x, double *jacobian) {
  (void)c, (void)w, (void)x;
  const double a225 = x[1] - W(5);
  const double a227 = a225 - C(45);
  const s_mask a228 = s_all(0.0) <= a227;
  const double a229 = s_all(1.0) - s_number(a228);
  const double a230 = a225 + C(45);
  const double a231 = -a230;
  const s_mask a232 = s_all(0.0) <= a231;
  const double a233 = a229 * s_number(a232);
  const double a306 = s_number(a228) + a233;
  const double a308 = a306 * W(9);
  const double a309 = -a308;
  const double a313 = a306 * W(10);
  const double a316 = a306 * W(11);
  const double a317 = a313 - a316;
  jacobian[0] = a309;
  jacobian[1] = a317;
  jacobian[2] = s_all(1.0);
  jacobian[3] = s_all(1.0);
  jacobian[4] = W(12);
  jacobian[5] = W(13);
}
void two_disk_gear_jacobian(const double *c, double t, const double *x, double *jacobian) {
  double w[two_disk_gear_W];
  jacobian_at(c, t, w);
  jacobian_of(c, w, x, jacobian);
}
#undef C
#undef W

/* Tables. */

const char *const two_disk_gear_state_names[two_disk_gear_X] = {
    "pinion.angle_deviation", "mesh.approach", "pinion.angle_deviation_rate", "mesh.approach_rate"
};
const char *const two_disk_gear_state_units[two_disk_gear_X] = {
    "rad", "m", "rad/s", "m/s"
};
const char *const two_disk_gear_parameter_names[two_disk_gear_P] = {
    "speed", "xi", "drive_mean", "pinion.inertia", "wheel.inertia", "mesh.teeth_a", "mesh.teeth_b", "mesh.module",
    "mesh.pressure_angle", "mesh.face_width", "mesh.young_modulus", "mesh.poisson_ratio", "mesh.shear_factor",
    "mesh.profile_shift_a", "mesh.profile_shift_b", "mesh.error_mean", "mesh.error_amplitude", "mesh.error_phase",
    "mesh.half_backlash", "drive.cosine[1]", "drive.cosine[2]", "drive.phase", "drive.scale", "load.mean", "load.phase",
    "load.scale", "mesh.geometry_rows[1]", "mesh.geometry_rows[2]", "mesh.geometry_rows[3]", "mesh.geometry_rows[4]",
    "mesh.geometry_rows[5]", "mesh.geometry_rows[6]", "mesh.geometry_rows[7]", "mesh.geometry_rows[8]", "mesh.geometry_rows[9]",
    "mesh.geometry_rows[10]", "mesh.geometry_rows[11]", "mesh.geometry_rows[12]", "mesh.geometry_rows[13]",
    "mesh.geometry_rows[14]", "mesh.geometry_rows[15]", "mesh.geometry_rows[16]", "mesh.geometry_rows[17]",
    "mesh.geometry_rows[18]", "mesh.geometry_rows[19]", "mesh.geometry_rows[20]", "mesh.geometry_rows[21]"
};
const char *const two_disk_gear_parameter_units[two_disk_gear_P] = {
    "rad/s", "1", "N*m", "kg*m^2", "kg*m^2", "1", "1", "m", "rad", "m", "Pa", "1", "1", "1", "1", "m", "m", "rad", "m", "N*m",
    "N*m", "rad", "1", "N*m", "rad", "1", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m",
    "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m", "N/m"
};
const char *const two_disk_gear_output_names[two_disk_gear_Y] = {
    "pinion.angle", "pinion.angle_deviation", "pinion.elastic_angle", "pinion.speed", "pinion.acceleration", "wheel.angle",
    "wheel.angle_deviation", "wheel.elastic_angle", "wheel.speed", "wheel.acceleration", "mesh.radius_a", "mesh.radius_b",
    "mesh.mesh_stiffness", "mesh.error", "mesh.error_rate", "mesh.mesh_damping", "mesh.approach", "mesh.deflection_rate",
    "mesh.deflection", "mesh.penetration", "mesh.force", "mesh.flank", "mesh.stored_energy", "mesh.dissipated_power",
    "drive.torque", "load.torque", "total.kinetic_energy", "total.stored_energy", "total.dissipated_power",
    "total.supplied_power"
};
const char *const two_disk_gear_output_units[two_disk_gear_Y] = {
    "rad", "rad", "rad", "rad/s", "rad/s^2", "rad", "rad", "rad", "rad/s", "rad/s^2", "m", "m", "N/m", "m", "m/s", "N*s/m", "m",
    "m/s", "m", "m", "N", "1", "J", "W", "N*m", "N*m", "J", "J", "W", "W"
};
const double two_disk_gear_start[two_disk_gear_X] = {
    0.0, 5.4004843204891015e-05, 0.0, 0.0
};
const double two_disk_gear_scale[two_disk_gear_X] = {
    0.00019730857041186194, 6.674738674818366e-06, 1.1178644577683792, 0.03781616335213632
};
const double two_disk_gear_parameter_values[two_disk_gear_P] = {
    125.66370614359172, 0.05, 60.0, 0.02, 0.3, 24.0, 48.0, 0.003, 0.3490658503988659, 0.02, 206000000000.0, 0.3, 1.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 4.9999999999999996e-05, 0.0, 40.0, 0.0, 1.0, (-120.0), 0.0, 1.0, 442871176.2365865, (-52699623.22915601),
    20984051.351594977, 320734.5910321042, (-13446394.095361117), 7683470.0998060675, 2127517.104545631, (-7894655.703702931),
    4071694.6662234245, 2414628.578561412, (-5582752.529639989), 91231417.3060143, 43634201.549755, 1781659.0341151755,
    19973144.64980644, 19354963.033041652, 1200559.2109132383, 10117961.357303113, 12876006.602280576, 1141895.5050998074,
    6213058.962003421
};
const unsigned char two_disk_gear_parameter_is_source[two_disk_gear_P] = {
    0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0
};
const int two_disk_gear_jacobian_rows[two_disk_gear_J] = {
    2, 3, 0, 1, 2, 3
};
const int two_disk_gear_jacobian_columns[two_disk_gear_J] = {
    1, 1, 2, 3, 3, 3
};

/* The solver: the classical Runge-Kutta method of order 4 by one step and two of half the size, whose difference measures the
 * error; a fifteenth of it is added to the result (Richardson). */

static double smaller(double a, double b) { return b < a ? b : a; }
static double larger(double a, double b) { return b > a ? b : a; }

/* What the state gains over a step h from base with the slope given there; w1, w2: time values in its middle and at its end. */
static void increment(two_disk_gear_run *run, const double *w1, const double *w2, double h, const double *base, const double *slope,
                      double *gain) {
  double *place = run->place, *rate = run->rate;
  int i;
  for (i = 0; i < two_disk_gear_X; ++i) place[i] = base[i] + h / 2 * slope[i];
  rates_of(run->c, w1, place, rate);
  for (i = 0; i < two_disk_gear_X; ++i) gain[i] = slope[i] + 2 * rate[i], place[i] = base[i] + h / 2 * rate[i];
  rates_of(run->c, w1, place, rate);
  for (i = 0; i < two_disk_gear_X; ++i) gain[i] += 2 * rate[i], place[i] = base[i] + h * rate[i];
  rates_of(run->c, w2, place, rate);
  for (i = 0; i < two_disk_gear_X; ++i) gain[i] = h / 6 * (gain[i] + rate[i]);
}

/* Try a step from run->time to a later time: its error, the largest in scales. */
static int try_step(two_disk_gear_run *run, double until, double *error) {
  double h = until - run->time, worst = 0, far = 0, sum = 0, base[two_disk_gear_X];
  int i;
  for (i = 0; i < 4; ++i) rates_at(run->c, i < 3 ? run->time + 0.25 * (i + 1) * h : until, run->w[i]);
  for (i = 0; i < two_disk_gear_X; ++i) base[i] = run->origin[i] + run->moved[i];
  increment(run, run->w[1], run->w[3], h, base, run->slope, run->whole);
  increment(run, run->w[0], run->w[1], h / 2, base, run->slope, run->first);
  for (i = 0; i < two_disk_gear_X; ++i) base[i] += run->first[i];
  rates_of(run->c, run->w[1], base, run->slope_half);
  increment(run, run->w[2], run->w[3], h / 2, base, run->slope_half, run->second);
  for (i = 0; i < two_disk_gear_X; ++i) {
    double both = run->first[i] + run->second[i], difference = both - run->whole[i], correction = difference / 15;
    run->moved_middle[i] = run->moved[i] + (run->first[i] + correction / 2);
    run->moved_end[i] = run->moved[i] + (both + correction);
    base[i] = run->origin[i] + run->moved_end[i];
    difference *= run->inverse[i];
    worst = larger(worst, fabs(difference));
    far = larger(far, fabs(run->moved_end[i] * run->inverse[i]));
    sum += difference * difference; /* finite only if everything is */
    sum += run->moved_end[i] * run->inverse[i] * run->moved_end[i] * run->inverse[i];
  }
  rates_of(run->c, run->w[3], base, run->slope_end);
  for (i = 0; i < two_disk_gear_X; ++i) {
    double move = h * run->slope_end[i] * run->inverse[i];
    sum += move * move;
  }
  *error = worst;
  return !isfinite(sum) ? two_disk_gear_NOT_FINITE : far > 10000000000.0 ? two_disk_gear_DIVERGED : two_disk_gear_OK;
}

/* Take over the step that was tried. */
static void accept(two_disk_gear_run *run, double until) {
  int i;
  for (i = 0; i < two_disk_gear_X; ++i) {
    run->moved_before[i] = run->moved[i], run->slope_before[i] = run->slope[i];
    run->moved[i] = run->moved_end[i], run->slope[i] = run->slope_end[i];
    run->slope_middle[i] = run->slope_half[i];
  }
  run->time_before = run->time, run->time = until;
  ++run->steps;
}

int two_disk_gear_init(two_disk_gear_run *run, double time, const double *x, const double *p) {
  double sum = 0;
  int i;
  two_disk_gear_prepare(p ? p : two_disk_gear_parameter_values, run->c);
  for (i = 0; i < two_disk_gear_X; ++i) {
    run->origin[i] = x ? x[i] : two_disk_gear_start[i], run->inverse[i] = 1 / two_disk_gear_scale[i];
    run->moved[i] = run->moved_before[i] = run->moved_middle[i] = 0;
  }
  two_disk_gear_rates(run->c, time, run->origin, run->slope);
  for (i = 0; i < two_disk_gear_X; ++i) {
    run->slope_before[i] = run->slope_middle[i] = run->slope[i];
    sum += 0 * run->slope[i] + 0 * run->origin[i];
  }
  run->time = run->time_before = run->end = time;
  run->steps = run->rejected = 0;
  run->tolerance = two_disk_gear_TOLERANCE, run->next = run->smallest = 0, run->last_error = 1;
  return isfinite(sum) ? two_disk_gear_OK : two_disk_gear_NOT_FINITE;
}

int two_disk_gear_step(two_disk_gear_run *run, double until) {
  double error;
  int status = until > run->time ? try_step(run, until, &error) : two_disk_gear_STEP_TOO_SMALL;
  if (status == two_disk_gear_OK) accept(run, until);
  return status;
}

void two_disk_gear_begin(two_disk_gear_run *run, double end, double tolerance) {
  /* Hairer's starting rule, with time measured in units in which a state moves by a hundredth of its scale. */
  double horizon = end - run->time, reach = larger(fabs(run->time), fabs(end)), speed = 0, bend = 0, sum = 0, unit, size;
  int i;
  run->end = end, run->tolerance = tolerance, run->last_error = 1;
  run->smallest = larger(1e-13 * horizon, 4 * (nextafter(reach, INFINITY) - reach));
  run->next = run->smallest;
  if (!(horizon > 0)) return;
  for (i = 0; i < two_disk_gear_X; ++i) speed = larger(speed, fabs(run->slope[i] * run->inverse[i]));
  unit = smaller(speed > 0 ? 0.01 / speed : 1e-06 * horizon, horizon);
  for (i = 0; i < two_disk_gear_X; ++i) run->place[i] = run->origin[i] + (run->moved[i] + unit * run->slope[i]);
  two_disk_gear_rates(run->c, run->time + unit, run->place, run->rate);
  for (i = 0; i < two_disk_gear_X; ++i) {
    double turn = (run->rate[i] - run->slope[i]) * run->inverse[i];
    bend = larger(bend, fabs(turn)), sum += turn;
  }
  size = larger(unit * speed, unit * bend);
  if (isfinite(sum) && isfinite(size))
    run->next = larger(run->smallest, unit * smaller(100.0, size > 0 ? pow(0.01 * tolerance / size, 0.2) : 100.0));
}

int two_disk_gear_advance(two_disk_gear_run *run) {
  double h = run->next, growth = 5.0, error = 0, factor, until;
  for (;;) {
    double left = run->end - run->time;
    int status;
    if (!(left > 0)) return two_disk_gear_OK;
    /* No sliver is left before the end; h is exactly the distance of two times. */
    until = h >= left ? run->end : run->time + (2 * h > left ? left / 2 : h);
    h = until - run->time;
    status = try_step(run, until, &error);
    error = status == two_disk_gear_NOT_FINITE ? INFINITY : error / run->tolerance;
    if (error <= 1 && status == two_disk_gear_DIVERGED) return status;
    if (error <= 1) break;
    ++run->rejected;
    h *= larger(0.2, isfinite(error) ? 0.9 * pow(error, -0.2) : 0);
    growth = 1; /* it grows not at once after a rejection */
    if (!(h >= run->smallest)) return status == two_disk_gear_NOT_FINITE ? status : two_disk_gear_STEP_TOO_SMALL;
  }
  accept(run, until);
  error = larger(error, 1e-10);
  factor = 0.9 * pow(error, -0.17) * pow(run->last_error, 0.04000000000000001);
  run->next = larger(run->smallest, h * smaller(growth, larger(0.2, factor)));
  run->last_error = error;
  return two_disk_gear_OK;
}

void two_disk_gear_state(const two_disk_gear_run *run, double time, double *x) {
  double width = run->time - run->time_before, theta = width > 0 ? (time - run->time_before) / width : 1;
  /* Weights of values (a, b, e) and slopes at start, middle and end: Hermite's quintic. The values' weights add up to one. */
  double a = 2 * (theta - 0.5) * (theta - 1), b = -4 * theta * (theta - 1), e = 2 * theta * (theta - 0.5);
  int i;
  a *= a, b *= b, e *= e;
  for (i = 0; i < two_disk_gear_X; ++i) {
    double y = run->moved_before[i];
    x[i] = run->origin[i] +
           (y + theta * a * width * run->slope_before[i] + b * (run->moved_middle[i] - y) +
            (theta - 0.5) * b * width * run->slope_middle[i] + (7 - 6 * theta) * e * (run->moved[i] - y) +
            (theta - 1) * e * width * run->slope[i]);
  }
}
