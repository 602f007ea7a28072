/* What a solution of a = W F + b is for several rigid contacts: the pieces of the law of each contact and
 * the systems that they make, and the contact problem of contacts at rest, with the residual of a
 * solution and the differences of two. Nothing here knows a model. */

#ifdef PS_RIGID
/* Most pieces of the law of a contact: apart, held with slip to either side and stuck, pushing likewise. */
#define PS_PIECES_OF_LAW 7

/* Residuals, roundings and noise of a contact problem, as in problem/law.py. */
static const double PS_RESIDUAL = 1e-10, PS_NOISE = 1e-13,
                    PS_DIFFERENCE_ROUNDING = 8.881784197001252e-16, PS_DISTINCT = 1e-8;

/* What a contact does. */
enum { PS_APART, PS_SLIP_POS, PS_SLIP_NEG, PS_STUCK };

/* A piece of the law of one contact, linear in its force F and acceleration a, or in dP/dtau and
 * dv/dtau: F = fixed + directions * unknowns, entries of a that the unknowns make vanish, and
 * `sign * a_entry >= 0`. Entries are 0 normal, 1 tangential. `side` is the sign of F_n of a guide that
 * slips, or 0 for either. */
typedef struct {
  double fixed[2], direction[2][2];
  int mode, unknowns, vanishing[2], inequalities, entry[2], sign[2], side;
} ps_piece;

/* The pieces of all contacts, those that stand `at` their places taken together. */
typedef struct {
  ps_piece offered[PS_RIGID][PS_PIECES_OF_LAW];
  int count[PS_RIGID], at[PS_RIGID];
  const ps_piece *taken[PS_RIGID];
} ps_pieces;

/* The linear system of the pieces taken: rows of a that vanish, columns of F that extend. */
typedef struct {
  int size, row[PS_ROWS], contact[PS_ROWS];
  const double *along[PS_ROWS];
  ps_square matrix;
} ps_system;

/* ---- pieces of the law, and the systems that they make ---- */

/* A contact that stays closed, with a normal force of the sign `side`. */
static void close_piece(int mode, double mu, int side, ps_piece *piece) {
  const double slope = side * mu;
  memset(piece, 0, sizeof *piece);
  piece->mode = mode;
  piece->unknowns = 1 + (mode == PS_STUCK && mu > 0);
  piece->vanishing[1] = 1;
  piece->direction[0][0] = piece->direction[1][1] = 1;
  if (mode == PS_SLIP_POS && mu > 0) piece->direction[0][1] = -slope;
  if (mode == PS_SLIP_NEG) piece->direction[0][1] = slope;
}

/* The same with a normal force that is given. */
static void give_normal(ps_piece *piece, double force) {
  for (int entry = 0; entry < 2; entry++) {
    piece->fixed[entry] = force * piece->direction[0][entry];
    piece->direction[0][entry] = piece->direction[1][entry];
  }
  piece->vanishing[0] = 1;
  piece->unknowns--;
}

static void with_sign(ps_piece *piece, int entry, int sign) {
  piece->entry[piece->inequalities] = entry;
  piece->sign[piece->inequalities++] = sign;
}

/* What a closed contact may do with the slip velocity v_t: slip on, or begin to slip either way, or
 * stick; with either sign of F_n where `guided`. Without friction no piece depends on a direction. */
static int closed_pieces(double mu, double v_t, int guided, ps_piece *pieces) {
  const int rests = v_t == 0 && mu > 0, sides = guided && mu > 0;
  int n = 0;
  for (int k = 0; k < 1 + rests; k++)
    for (int side = 1; side >= (sides ? -1 : 1); side -= 2) {
      ps_piece *piece = &pieces[n++];
      close_piece(mu > 0 && (v_t < 0 || k) ? PS_SLIP_NEG : PS_SLIP_POS, mu, side, piece);
      if (sides) piece->side = side;
      if (rests) with_sign(piece, 1, k ? -1 : 1);
    }
  if (rests) close_piece(PS_STUCK, mu, 1, &pieces[n++]);
  return n;
}

static int apart_piece(ps_piece *piece) {
  memset(piece, 0, sizeof *piece);
  return 1;
}

static void take_first(int n, ps_pieces *pieces) {
  memset(pieces->at, 0, sizeof pieces->at);
  for (int i = 0; i < n; i++) pieces->taken[i] = pieces->offered[i];
}

/* Takes the next combination; 0 after the last. */
static int take_next(int n, ps_pieces *pieces) {
  for (int i = n - 1; i >= 0; i--) {
    pieces->at[i] = (pieces->at[i] + 1) % pieces->count[i];
    pieces->taken[i] = &pieces->offered[i][pieces->at[i]];
    if (pieces->at[i]) return 1;
  }
  return 0;
}

/* Writes the fixed part of the forces, and the system of the unknown one. */
static void make_system(int n, ps_square W, const ps_piece *const *taken, double *force,
                        ps_system *system) {
  int k = 0;
  for (int i = 0; i < n; i++) {
    force[PS_N(i)] = taken[i]->fixed[0];
    force[PS_T(i, 0)] = taken[i]->fixed[1];
    for (int u = 0; u < taken[i]->unknowns; u++) {
      system->row[k] = PS_ROW(i, taken[i]->vanishing[u]);
      system->contact[k] = i;
      system->along[k++] = taken[i]->direction[u];
    }
  }
  system->size = k;
  for (int r = 0; r < k; r++)
    for (int c = 0; c < k; c++) {
      const double *row = &W[system->row[r]][PS_N(system->contact[c])];
      const double first = row[0] * system->along[c][0], second = row[1] * system->along[c][1];
      const double terms = fabs(first) + fabs(second), sum = first + second;
      /* A sign that rounding leaves would be an accident. */
      system->matrix[r][c] = fabs(sum) <= PS_DIFFERENCE_ROUNDING * terms ? 0 : sum;
    }
}

/* Adds what the unknowns x make of the forces. */
static void extend(const ps_system *system, const double *x, double *force) {
  for (int c = 0; c < system->size; c++)
    for (int entry = 0; entry < 2; entry++)
      force[PS_ROW(system->contact[c], entry)] += system->along[c][entry] * x[c];
}

/* ---- contacts at rest ---- */

/* The contact problem of contacts without slip, a = aim + W P with 0 <= P_n, a_n >= 0, P_n a_n = 0, or
 * a_n = 0 where held, and friction against a_t, scaled row by row by powers of two. */
typedef struct {
  int n;
  const int *held;
  ps_square W;
  double aim[PS_ROWS], mu[PS_RIGID], unit[PS_ROWS];
} ps_problem;

static void scaled_problem(int n, ps_square W, const double *aim, const double *mu, const int *held,
                           ps_problem *p) {
  double d[PS_ROWS], largest = 0;
  int exponent;
  p->n = n;
  p->held = held;
  for (int i = 0; i < PS_SIZE(n); i++) {
    frexp(W[i][i], &exponent);
    /* Rounded down, also below zero. */
    d[i] = W[i][i] > 0 ? ldexp(1, exponent >= 0 ? exponent / 2 : -((1 - exponent) / 2)) : 1;
    largest = PS_MAX(largest, fabs(aim[i] / d[i]));
  }
  frexp(largest, &exponent);
  double size = largest > 0 ? ldexp(1, exponent) : 1;
  for (int i = 0; i < PS_SIZE(n); i++) {
    for (int j = 0; j < PS_SIZE(n); j++) p->W[i][j] = W[i][j] / (d[i] * d[j]);
    p->aim[i] = aim[i] / d[i] / size;
    p->unit[i] = size / d[i];
  }
  for (int i = 0; i < n; i++) p->mu[i] = mu[i] * d[PS_T(i, 0)] / d[PS_N(i)];
}

/* Accelerations, and the sum of the sizes of the terms of each. */
static void accelerations(const ps_problem *p, const double *P, double *a, double *terms) {
  for (int i = 0; i < PS_SIZE(p->n); i++) {
    a[i] = dot(PS_SIZE(p->n), p->W[i], P) + p->aim[i];
    terms[i] = terms_of(PS_SIZE(p->n), p->W[i], P) + fabs(p->aim[i]);
  }
}

static double ratio(double part, double whole) { return whole > 0 ? part / whole : 0; }

/* How much an entry of the impulses matters to any acceleration. */
static double matters(const ps_problem *p, int j, double size, const double *terms) {
  double share = 0, effect = 0;
  for (int i = 0; i < PS_SIZE(p->n); i++) {
    share = PS_MAX(share, ratio(fabs(p->W[i][j]) * size, terms[i]));
    effect = PS_MAX(effect, fabs(p->W[i][j]));
  }
  return effect > 0 || !(size > 0) ? share : 1;
}

/* By how much impulses within their cones miss the laws of the contacts, free of units. */
static double residual(const ps_problem *p, const double *P) {
  double a[PS_ROWS], terms[PS_ROWS], worst = 0;
  accelerations(p, P, a, terms);
  for (int i = 0; i < p->n; i++) {
    const int n = PS_N(i), t = PS_T(i, 0);
    double gap = ratio(a[n], terms[n]), slip = ratio(a[t], terms[t]);
    double weight = matters(p, n, fabs(P[n]), terms), limit = p->mu[i] * fabs(P[n]);
    double span = fabs(P[t]) + limit, s = (slip > 0) - (slip < 0);
    double missed = ratio(fabs(P[t] + s * limit), span);
    worst = PS_MAX(worst, p->held[i] ? fabs(gap) : PS_MIN(weight, fabs(gap)));
    worst = PS_MAX(worst, -gap);
    worst = PS_MAX(worst, PS_MIN(missed, fabs(slip)));
  }
  return worst;
}

/* Removes what a solve may have left of zeros, and holds impulses to the cones of their modes; returns
 * the residual. */
static double cleaned_impulses(const ps_problem *p, const int *mode, double *P) {
  const int rows = PS_SIZE(p->n);
  double given[PS_ROWS], P_try[PS_ROWS], a[PS_ROWS], terms[PS_ROWS], largest = 0, best = HUGE_VAL;
  memcpy(given, P, sizeof given);
  accelerations(p, given, a, terms);
  for (int i = 0; i < rows; i++)
    largest = PS_MAX(largest, sqrt(p->W[i][i]) * fabs(given[i]));
  for (int attempt = 0; attempt < 3 && best > PS_SUM_ROUNDING; attempt++) {
    for (int i = 0; i < rows; i++) {
      const int other = PS_ROW(PS_CONTACT_OF(i), !PS_AXIS_OF(i));
      double size = sqrt(p->W[i][i]) * fabs(given[i]);
      int noise = size > 0 && size <= PS_NOISE * largest;
      int idle = matters(p, i, fabs(given[i]), terms) <= PS_RESIDUAL &&
                 matters(p, other, fabs(given[other]), terms) <= PS_RESIDUAL;
      P_try[i] = (attempt == 0 && noise) || (attempt == 2 && idle) ? 0 : given[i];
    }
    for (int i = 0; i < p->n; i++) {
      double *n = &P_try[PS_N(i)], *t = &P_try[PS_T(i, 0)], limit = p->mu[i] * fabs(*n);
      if (*n <= 0 && !p->held[i]) *n = *t = 0;
      else if (mode[i] == PS_STUCK) *t = PS_MIN(PS_MAX(*t, -limit), limit);
      else *t = mode[i] == PS_SLIP_POS ? -limit : limit;
    }
    double measured = residual(p, P_try);
    if (measured < best) {
      best = measured;
      memcpy(P, P_try, sizeof P_try);
    }
  }
  return best;
}

/* Modes as the accelerations show them where they are on a border. */
static void shown_modes(const ps_problem *p, const double *P, int *mode) {
  double a[PS_ROWS], terms[PS_ROWS];
  accelerations(p, P, a, terms);
  for (int i = 0; i < p->n; i++) {
    const int t = PS_T(i, 0);
    if (P[PS_N(i)] == 0 && !p->held[i]) mode[i] = PS_APART;
    else if (mode[i] != PS_STUCK || fabs(a[t]) > PS_RESIDUAL * terms[t])
      mode[i] = fabs(a[t]) <= PS_SUM_ROUNDING * terms[t] ? PS_STUCK
                : a[t] > 0                               ? PS_SLIP_POS
                                                         : PS_SLIP_NEG;
  }
}

/* Impulses of the pieces taken; 0: there are none. */
static int impulses_of(const ps_problem *p, const ps_piece *const *taken, double *P) {
  ps_system system;
  double right[PS_ROWS], x[PS_ROWS];
  make_system(p->n, (double (*)[PS_ROWS])p->W, taken, P, &system);
  for (int r = 0; r < system.size; r++) right[r] = -p->aim[system.row[r]];
  if (!solved(system.size, system.matrix, right, x)) return 0;
  extend(&system, x, P);
  return 1;
}

/* Whether the first impulses are less by their residual and rounded sums, and then in their order. */
static int is_less(const ps_problem *p, const double *sum, const double *P, const double *least,
                   const double *Q) {
  for (int i = 0; i < 3; i++)
    if (sum[i] != least[i]) return sum[i] < least[i];
  for (int entry = 0; entry < 2; entry++)
    for (int i = entry; i < PS_SIZE(p->n); i += PS_AXES)
      if (fabs(P[i] - Q[i]) > PS_DISTINCT * PS_MAX(fabs(P[i]), fabs(Q[i]))) return P[i] < Q[i];
  return 0;
}

/* Whether impulses change a velocity by more than rounding. */
static int changes_velocity(const ps_problem *p, const double *P) {
  const int rows = PS_SIZE(p->n);
  int changes = 0;
  for (int i = 0; i < rows; i++)
    changes |= fabs(dot(rows, p->W[i], P)) > PS_RATE_ROUNDING * terms_of(rows, p->W[i], P);
  return changes;
}
#endif
