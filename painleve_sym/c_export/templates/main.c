/* $title
 *
$case
 *
 * Prints every event and the end, with 17 digits: what expected.txt holds, as computed by
 * painleve-sym with
 *   $compiler
 *   $flags */

#include "${name}_model.h"

#include <stdio.h>

static void print_values(const char *const *names, const double *values, int n) {
  for (int i = 0; i < n; i++) printf("  %s %.17g\n", names[i], values[i]);
}

$print_modes
int main(void) {
  static const double p[${NAME}_PARAMETERS] = {
$parameters
  };
  double x[${NAME}_STATES] = {
$state
  };
  ${name}_options options;
  ${name}_run *run;

  ${name}_complete_state(p, x);
$press  ${name}_default_options(p, x, $t_end, $rtol, &options);
$options  run = ${name}_simulate(p, x, &options);
  if (!run) {
    fprintf(stderr, "no memory\n");
    return 1;
  }
  for (long i = 0; i < run->event_count; i++) {
    const ${name}_event *e = &run->events[i];
$print_event    print_values(${name}_state_names, e->after, ${NAME}_STATES);
  }
$print_end  print_values(${name}_state_names, run->state, ${NAME}_STATES);
  print_values(${name}_output_names, run->outputs, ${NAME}_OUTPUTS);
  printf("steps %ld accepted, %ld rejected\n", run->accepted_steps, run->rejected_steps);
  ${name}_free(run);
  return 0;
}
