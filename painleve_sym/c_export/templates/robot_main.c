/* Example: the risk at one pose. Build: cc -O2 -o example $name.c main.c -lm */
#include <stdio.h>
#include <stdlib.h>

#include "$name.h"

int main(int count, char **words) {
  double joints[$room] = {$joints}, normal[3] = {$normal};
  ${name}_risk risk;
  long k, repeat = count > 1 ? atol(words[1]) : 1;
  for (k = 0; k < repeat; ++k) ${name}_compute(joints, normal, &risk);
  for (k = 0; k < 9; ++k) printf("%.17g\n", risk.W[k / 3][k % 3]);
  printf("%.17g\n%.17g\n", risk.mu_P, risk.direction);
  return 0;
}
