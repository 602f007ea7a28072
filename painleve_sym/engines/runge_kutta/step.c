/* One Runge-Kutta step, its error and its dense output. */

#define STAGE(row, n)                                            \
  for (int i = 0; i < PS_NX; i++) y[i] = x[i] + h * (row);       \
  field(s, y, k[n]);

/* From x with k[0] = f(x): the end state y after h, stages 1..11 in k. */
static void step(ps_run *s, const double *x, double h, double *y) {
  double(*k)[PS_NX] = s->k;
  STAGE(PS_ROW_1, 1)
  STAGE(PS_ROW_2, 2)
  STAGE(PS_ROW_3, 3)
  STAGE(PS_ROW_4, 4)
  STAGE(PS_ROW_5, 5)
  STAGE(PS_ROW_6, 6)
  STAGE(PS_ROW_7, 7)
  STAGE(PS_ROW_8, 8)
  STAGE(PS_ROW_9, 9)
  STAGE(PS_ROW_10, 10)
  STAGE(PS_ROW_11, 11)
  for (int i = 0; i < PS_NX; i++) y[i] = x[i] + h * (PS_ROW_12);
}

/* Weighted error norm of the last step; the step is good when it is below 1. */
static double error_norm(ps_run *s, const ps_options *o, const double *x, const double *y,
                         double h) {
  double(*k)[PS_NX] = s->k;
  double e5 = 0, e3 = 0;
  for (int i = 0; i < PS_NX; i++) {
    double before = fabs(x[i]), after = fabs(y[i]);
    double weight = 1 / (o->atol[i] + o->rtol * PS_MAX(before, after));
    double a = (PS_E5) * weight, b = (PS_E3) * weight;
    e5 += a * a;
    e3 += b * b;
  }
  double sum = e5 + 0.01 * e3;
  if (!(sum > 0)) return sum == 0 ? 0 : NAN;
  return fabs(h) * e5 / sqrt(sum * PS_NX);
}

/* Rows of the dense polynomial of a step from x to y; k[12] holds f(y). */
static void dense_rows(ps_run *s, const double *x, const double *end, double h,
                       double row[8][PS_NX]) {
  double(*k)[PS_NX] = s->k;
  double y[PS_NX];
  STAGE(PS_ROW_13, 13)
  STAGE(PS_ROW_14, 14)
  STAGE(PS_ROW_15, 15)
  for (int i = 0; i < PS_NX; i++) {
    double d = end[i] - x[i];
    row[0][i] = x[i];
    row[1][i] = d;
    row[2][i] = h * k[0][i] - d;
    row[3][i] = 2 * d - h * (k[12][i] + k[0][i]);
    row[4][i] = h * (PS_D_0);
    row[5][i] = h * (PS_D_1);
    row[6][i] = h * (PS_D_2);
    row[7][i] = h * (PS_D_3);
  }
  s->count.dense++;
}

static void dense_eval(double row[8][PS_NX], double u, double *x) {
  double v = 1 - u;
  for (int i = 0; i < PS_NX; i++)
    x[i] = row[0][i]
           + u * (row[1][i]
                  + v * (row[2][i]
                         + u * (row[3][i]
                                + v * (row[4][i]
                                       + u * (row[5][i] + v * (row[6][i] + u * row[7][i]))))));
}
