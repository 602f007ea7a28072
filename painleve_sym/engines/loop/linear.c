/* Small dense linear systems, of two rows for each rigid contact: singular values, least squares, and
 * elimination. */

#ifdef PS_RIGID
#define PS_ROWS PS_SIZE(PS_RIGID)

/* Of the sum of the terms of a rate, or of the largest singular value: less is the rounding of an inverse
 * mass matrix. */
static const double PS_RATE_ROUNDING = 1e-12;
/* Of the terms of a sum: what a solve may leave of a zero. */
static const double PS_SUM_ROUNDING = 1e-14;

typedef double ps_square[PS_ROWS][PS_ROWS];

static double dot(int n, const double *a, const double *b) {
  double sum = 0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* The sum of the sizes of the terms of `dot`. */
static double terms_of(int n, const double *a, const double *b) {
  double sum = 0;
  for (int i = 0; i < n; i++) sum += fabs(a[i]) * fabs(b[i]);
  return sum;
}

/* Makes the rows of `a` orthogonal by plane rotations from the left, which are gathered in `turn`
 * (one-sided Jacobi, Hestenes 1958). The norms of the rows are then the singular values. */
static void orthogonal_rows(int k, ps_square a, ps_square turn) {
  for (int i = 0; i < k; i++)
    for (int j = 0; j < k; j++) turn[i][j] = i == j;
  for (int sweep = 0, turned = 1; turned && sweep < 40; sweep++) {
    turned = 0;
    for (int p = 0; p < k; p++) {
      for (int q = p + 1; q < k; q++) {
        double pp = dot(k, a[p], a[p]), qq = dot(k, a[q], a[q]), pq = dot(k, a[p], a[q]);
        if (!(fabs(pq) > 1e-16 * sqrt(pp) * sqrt(qq)) || PS_MIN(pp, qq) <= 1e-36 * PS_MAX(pp, qq))
          continue;
        double cot = (qq - pp) / (2 * pq), r = sqrt(1 + cot * cot);
        double t = cot >= 0 ? 1 / (cot + r) : 1 / (cot - r), c = 1 / sqrt(1 + t * t), s = t * c;
        for (int i = 0; i < k; i++) {
          double x = a[p][i], y = a[q][i], u = turn[p][i], w = turn[q][i];
          a[p][i] = c * x - s * y;
          a[q][i] = s * x + c * y;
          turn[p][i] = c * u - s * w;
          turn[q][i] = s * u + c * w;
        }
        turned = 1;
      }
    }
  }
}

/* Singular value decomposition: rows of `a` with the singular values as norms, and `turn`, so that
 * matrix' = turn' a or, where `across`, matrix = turn' a. Returns which of them are not zero. */
static void decompose(int k, ps_square matrix, int across, ps_square a, ps_square turn, int *live) {
  double largest = 0, square[PS_ROWS];
  for (int i = 0; i < k; i++)
    for (int j = 0; j < k; j++) a[i][j] = across ? matrix[i][j] : matrix[j][i];
  orthogonal_rows(k, a, turn);
  for (int i = 0; i < k; i++) largest = PS_MAX(largest, square[i] = dot(k, a[i], a[i]));
  for (int i = 0; i < k; i++) live[i] = sqrt(square[i]) > PS_RATE_ROUNDING * sqrt(largest);
}

/* Least squares solution of least norm of `matrix x = right`. */
static void least_norm(int k, ps_square matrix, const double *right, double *x) {
  ps_square a, turn;
  int live[PS_ROWS];
  if (k == 1) {
    x[0] = matrix[0][0] != 0 ? right[0] / matrix[0][0] : 0;
    return;
  }
  decompose(k, matrix, 0, a, turn, live);
  for (int j = 0; j < k; j++) x[j] = 0;
  for (int i = 0; i < k; i++) {
    double share = live[i] ? dot(k, a[i], right) / dot(k, a[i], a[i]) : 0;
    for (int j = 0; j < k; j++) x[j] += share * turn[i][j];
  }
}

/* The limit for e -> 0 of the solution of (matrix + e) x = right: where the matrix is singular, the
 * solution that lies in its range. */
static void solve_in_range(int k, ps_square matrix, const double *right, double *x) {
  ps_square a, left, turn, small;
  int live[PS_ROWS], beyond[PS_ROWS], way[PS_ROWS], rows = 0, columns = 0;
  double out[PS_ROWS] = {0}, y[PS_ROWS] = {0};
  least_norm(k, matrix, right, x);
  decompose(k, matrix, 0, a, turn, live);
  for (int i = 0; i < k; i++)
    if (!live[i]) way[columns++] = i;
  if (!columns) return;
  decompose(k, matrix, 1, a, left, live);
  for (int i = 0; i < k; i++)
    if (!live[i]) beyond[rows++] = i;
  if (rows != columns) return;
  for (int i = 0; i < rows; i++) {
    out[i] = dot(k, left[beyond[i]], x);
    for (int j = 0; j < rows; j++) small[i][j] = dot(k, left[beyond[i]], turn[way[j]]);
  }
  least_norm(rows, small, out, y);
  for (int j = 0; j < rows; j++)
    for (int i = 0; i < k; i++) x[i] -= y[j] * turn[way[j]][i];
}

/* Gauss elimination with row pivots, refined once; 0 where a pivot vanishes. */
static int solved(int k, ps_square matrix, const double *right, double *x) {
  ps_square lu;
  double rest[PS_ROWS], y[PS_ROWS];
  int row[PS_ROWS];
  for (int i = 0; i < k; i++) {
    memcpy(lu[i], matrix[i], sizeof lu[i]);
    row[i] = i;
    x[i] = 0;
  }
  for (int j = 0; j < k; j++) {
    int best = j;
    for (int i = j + 1; i < k; i++)
      if (fabs(lu[row[i]][j]) > fabs(lu[row[best]][j])) best = i;
    int swap = row[j];
    row[j] = row[best];
    row[best] = swap;
    if (!(fabs(lu[row[j]][j]) > PS_SUM_ROUNDING * PS_ROWS)) return 0;
    for (int i = j + 1; i < k; i++) {
      double f = lu[row[i]][j] /= lu[row[j]][j];
      for (int m = j + 1; m < k; m++) lu[row[i]][m] -= f * lu[row[j]][m];
    }
  }
  for (int turn = 0; turn < 2; turn++) {
    for (int i = 0; i < k; i++) rest[i] = right[i] - dot(k, matrix[i], x);
    for (int i = 0; i < k; i++) y[i] = rest[row[i]] - dot(i, lu[row[i]], y);
    for (int i = k - 1; i >= 0; i--) {
      for (int m = i + 1; m < k; m++) y[i] -= lu[row[i]][m] * y[m];
      y[i] /= lu[row[i]][i];
    }
    for (int i = 0; i < k; i++) x[i] += y[i];
  }
  return 1;
}
#endif
