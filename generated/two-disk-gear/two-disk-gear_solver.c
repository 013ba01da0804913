/* two-disk-gear: a program that prints a trajectory as CSV; see two-disk-gear.h. Written by modelgen.
 *
 * Without arguments it prints the default case; --help says what can be asked for. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "two-disk-gear.h"

enum { REFUSED = 2 };
static const double most_steps = 2e7; /* with error control */

static int refuse(const char *what, const char *why) {
  fprintf(stderr, "two-disk-gear: %s: %s\n", what, why);
  return REFUSED;
}

static void help(void) {
  printf(
      "usage: two-disk-gear [--end S] [--samples N] [--tolerance T | --fixed S] [NAME=VALUE ...] [--parameters]\n"
      "Prints time and all outputs as CSV, from the static state of the default parameters.\n"
      "  --end S        end of the run [s], %g by default\n"
      "  --samples N    rows, equally spaced from 0 to the end, %d by default\n"
      "  --tolerance T  largest error of a step relative to the scale of each state, %g by default\n"
      "  --fixed S      equal steps of at most S [s] without error control\n"
      "  NAME=VALUE     a parameter in its unit; the start, the balance of the mean torques and the scales stay as they are\n"
      "  --parameters   print names, values and units of the parameters, and end\n",
      two_disk_gear_END, two_disk_gear_SAMPLES, two_disk_gear_TOLERANCE);
}

/* A finite number that is the whole text, at least so large. */
static int number(const char *text, double least, double *value) {
  char *rest;
  *value = strtod(text, &rest);
  return rest != text && *rest == '\0' && isfinite(*value) && *value >= least;
}

/* NAME=VALUE into p. */
static int assign(const char *text, double *p) {
  const char *equals = strchr(text, '=');
  size_t length = equals ? (size_t)(equals - text) : 0;
  int i;
  for (i = 0; i < two_disk_gear_P && equals; ++i)
    if (strlen(two_disk_gear_parameter_names[i]) == length && strncmp(two_disk_gear_parameter_names[i], text, length) == 0) {
      if (two_disk_gear_parameter_is_source[i]) return refuse(text, "others were computed from it; change the model and generate anew");
      return number(equals + 1, -HUGE_VAL, p + i) ? 0 : refuse(text, "give a finite number");
    }
  return refuse(text, "is neither an option nor NAME=VALUE of a parameter; see --help and --parameters");
}

static void print_names(void) {
  int i;
  printf("time [s]");
  for (i = 0; i < two_disk_gear_Y; ++i) {
    printf(",%s", two_disk_gear_output_names[i]);
    if (strcmp(two_disk_gear_output_units[i], "1") != 0) printf(" [%s]", two_disk_gear_output_units[i]);
  }
  printf("\n");
}

static void print_row(const two_disk_gear_run *run, double time) {
  double x[two_disk_gear_X], outputs[two_disk_gear_Y];
  int i;
  two_disk_gear_state(run, time, x);
  two_disk_gear_outputs(run->c, time, x, outputs);
  printf("%.12g", time);
  for (i = 0; i < two_disk_gear_Y; ++i) printf(",%.12g", outputs[i]);
  printf("\n");
}

int main(int count, char **arguments) {
  two_disk_gear_run run;
  double p[two_disk_gear_P], end = two_disk_gear_END, tolerance = two_disk_gear_TOLERANCE, fixed = 0, samples = two_disk_gear_SAMPLES, steps, step = 0, row = 0;
  int status, i;
  for (i = 0; i < two_disk_gear_P; ++i) p[i] = two_disk_gear_parameter_values[i];
  for (i = 1; i < count; ++i) {
    const char *option = arguments[i], *value = i + 1 < count ? arguments[i + 1] : "";
    if (strcmp(option, "--help") == 0) return help(), 0;
    if (strcmp(option, "--parameters") == 0) {
      for (i = 0; i < two_disk_gear_P; ++i) printf("%s,%.17g,%s\n", two_disk_gear_parameter_names[i], p[i], two_disk_gear_parameter_units[i]);
      return 0;
    }
    if (strncmp(option, "--", 2) != 0) {
      if (assign(option, p) != 0) return REFUSED;
      continue;
    }
    if (strcmp(option, "--end") == 0 && number(value, 1e-12, &end)) ++i;
    else if (strcmp(option, "--samples") == 0 && number(value, 2, &samples) && samples <= 1e9) ++i;
    else if (strcmp(option, "--tolerance") == 0 && number(value, 1e-15, &tolerance)) ++i;
    else if (strcmp(option, "--fixed") == 0 && number(value, 1e-15, &fixed)) ++i;
    else return refuse(option, "is no option, or what follows it is no such number; see --help");
  }
  samples = floor(samples);
  steps = fixed > 0 ? fmax(1.0, ceil(end / fixed * (1 - 1e-12))) : most_steps;
  status = two_disk_gear_init(&run, 0.0, 0, p);
  if (!(fixed > 0)) two_disk_gear_begin(&run, end, tolerance);
  print_names();
  for (;;) {
    for (; row < samples; ++row) {
      double time = row + 1 < samples ? row * (end / (samples - 1)) : end;
      if (status != two_disk_gear_OK || time > run.time) break;
      print_row(&run, time);
    }
    if (status != two_disk_gear_OK || !(run.time < end) || !(++step <= steps)) break;
    status = fixed > 0 ? two_disk_gear_step(&run, step < steps ? end * (step / steps) : end) : two_disk_gear_advance(&run);
  }
  if (fflush(stdout) != 0 || ferror(stdout)) {
    fprintf(stderr, "two-disk-gear: the output cannot be written: %s\n", strerror(errno));
    return 1;
  }
  if (status == two_disk_gear_OK && !(run.time < end)) return 0;
  fprintf(stderr, "two-disk-gear: stopped at %.9g s: %s\n", run.time,
          status == two_disk_gear_NOT_FINITE       ? "a rate or state is no finite number"
          : status == two_disk_gear_STEP_TOO_SMALL ? "the error control asks for too small a step"
          : status == two_disk_gear_DIVERGED       ? "a state has diverged"
                                           : "too many steps");
  return 1;
}
