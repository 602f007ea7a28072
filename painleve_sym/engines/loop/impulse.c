/* Impacts of several rigid contacts at once: the path of the impulse in straight pieces, as derived in
 * engines/simultaneous.py. Nothing here knows a model. */

#ifdef PS_RIGID
/* Of which restitution returns the share e^power. */
enum { PS_BY_VELOCITY, PS_BY_IMPULSE, PS_BY_WORK };

/* Of the largest force, or of the terms of a rate: what an inequality may be missed by. */
static const double PS_MISSED = 1e-9;
/* Events of a piece nearer to each other than this part of it happen at once. */
static const double PS_COINCIDENT = 1e-12;
/* Of the largest velocity before. Stops may accumulate in ever smaller velocities: one nearer than the
 * first to its border, or to 0 of a slip, is there, and so are all of the contacts that push where all
 * are nearer than the second. */
static const double PS_REST_SPEED = 1e-14, PS_ALL_REST_SPEED = 1e-10;
/* Of a mobility with a unit diagonal: a singular value below the first is zero. Of the largest
 * mobility: what is then added to tell the least of several impulses of one effect. */
static const double PS_SINGULAR_MOBILITY = 1e-12, PS_MORE_MOBILITY = 1e-8;
/* Of the sum of the terms of a rate: two that differ by less are one. */
static const double PS_EQUAL_RATES = 1e-6;
/* Pieces after which a path counts as endless; a path of two contacts has about ten. */
static const int PS_PIECES = 1000;

/* What a listener hears of a path, all as doubles: how it begins, and each of its steps. */
enum { PS_TOLD_COURSE, PS_TOLD_STEP, PS_TOLD_IMPACT, PS_TOLD_CLOSING };
typedef void (*ps_listener)(int what, const double *numbers, double *x);

/* The beginning, in numbers of order 1: 2^mass of W are 1/kg, 2^speed of v are 1 m/s. */
typedef struct {
  double n, mass, speed, W[PS_ROWS][PS_ROWS], mu[PS_RIGID], v[PS_ROWS], border[PS_RIGID];
} ps_course;

/* A straight piece, dP/dtau = push, with `end` what ends it after `length` at a contact; or impulses `push`
 * at once, by Newton's law with e of each contact, nan for a stop. Both are `fixed` + the columns times unknowns, which
 * make the rates of `row` vanish. `alone`: no other straight piece was possible. */
enum { PS_STRAIGHT, PS_ALL_AT_ONCE, PS_WEIGHS };
enum { PS_BORDER, PS_ENERGY_BACK, PS_SLIP_ZERO, PS_SPENT };
typedef struct {
  double kind, length, end, contact, work, alone, unknowns, row[PS_ROWS], e[PS_RIGID];
  double column[PS_ROWS][PS_ROWS], fixed[PS_ROWS], v[PS_ROWS], push[PS_ROWS], rates[PS_ROWS];
  double after[PS_ROWS], budget[PS_RIGID], budget_after[PS_RIGID], compresses[PS_RIGID];
  double rubs[PS_RIGID];
} ps_step;

/* The inputs are scaled to order 1. */
typedef struct {
  int n, measure, singular, guides, mass, speed;
  ps_listener listener; /* or NULL */
  const int *held; /* contacts that hold from both sides */
  double share[PS_RIGID]; /* e^power of each contact */
  ps_square W;
  double mu[PS_RIGID], v[PS_ROWS], start[PS_ROWS];
  double border[PS_RIGID], budget[PS_RIGID], weight[PS_RIGID], work;
  double impulses[PS_ROWS], works[PS_ROWS]; /* of all pieces so far */
} ps_path;

/* Tells the step what it is made of. */
static void note_system(const ps_system *system, ps_step *step) {
  step->unknowns = system->size;
  for (int c = 0; c < system->size; c++) {
    step->row[c] = system->row[c];
    for (int entry = 0; entry < PS_AXES; entry++)
      step->column[PS_ROW(system->contact[c], entry)][c] = system->along[c][entry];
  }
}

static double rounded_to_nine(double x) { return nearbyint(x * 1e9); }

/* ---- impulses that stop all contacts at once ---- */

/* Solution of least normal impulse of the contacts that open, with its modes and accelerations; where
 * `moving`, of those that change a velocity. 0: there is none. */
static int least_impulses(const ps_path *path, ps_square W, const double *aim, int moving, double *P,
                          double *a, int *mode) {
  const int n = path->n;
  ps_problem p;
  ps_pieces pieces;
  int shown[PS_RIGID], possible = 0;
  double best[PS_ROWS], least[3] = {0}, now[PS_ROWS], terms;
  scaled_problem(n, W, aim, path->mu, path->held, &p);
  for (int i = 0; i < n; i++) {
    ps_piece *offered = pieces.offered[i];
    const int opens = path->held[i] ? 0 : apart_piece(offered);
    pieces.count[i] = opens + closed_pieces(p.mu[i], 0, path->held[i], offered + opens);
  }
  take_first(n, &pieces);
  do {
    double sum[3] = {0}, missed;
    for (int i = 0; i < n; i++) shown[i] = pieces.taken[i]->mode;
    if (impulses_of(&p, pieces.taken, now) && (missed = cleaned_impulses(&p, shown, now)) <= PS_RESIDUAL &&
        (!moving || changes_velocity(&p, now))) {
      /* With a little mobility added, other shares of the same impulses miss the laws by that little. */
      sum[0] = missed > PS_NOISE;
      for (int i = 0; i < n; i++) {
        const double normal = now[PS_N(i)];
        sum[1 + (path->held[i] != 0)] += (path->held[i] ? fabs(normal) : normal) * p.unit[PS_N(i)];
      }
      for (int i = 1; i < 3; i++) sum[i] = rounded_to_nine(sum[i]);
      if (!possible || is_less(&p, sum, now, least, best)) {
        shown_modes(&p, now, shown);
        memcpy(mode, shown, sizeof shown);
        memcpy(best, now, sizeof best);
        memcpy(least, sum, sizeof least);
        possible = 1;
      }
    }
  } while (take_next(n, &pieces));
  if (!possible) return 0;
  for (int i = 0; i < PS_SIZE(n); i++) P[i] = best[i] * p.unit[i];
  for (int i = 0; i < PS_SIZE(n); i++) {
    const int local = mode[PS_CONTACT_OF(i)];
    const int held = local == PS_STUCK || (!PS_AXIS_OF(i) && local != PS_APART);
    a[i] = dot(PS_SIZE(n), W[i], P) + aim[i];
    terms = fabs(aim[i]);
    for (int j = 0; j < PS_SIZE(n); j++) terms += fabs(W[i][j]) * fabs(P[j]);
    if (held || fabs(a[i]) <= PS_SUM_ROUNDING * terms) a[i] = 0;
  }
  return 1;
}

/* Whether impulses meet the laws of the contacts with `still` rates that vanish; writes the rates, 0 where
 * they are rounding. There is no limit where the impulses of their modes grow without bound. */
static int is_limit(const ps_path *path, const double *aim, const double *P, const int *still, int k,
                    double *a) {
  const int rows = PS_SIZE(path->n);
  double share[PS_ROWS], size[PS_ROWS], sum = 0, largest = 0, worst = 0;
  for (int i = 0; i < rows; i++) {
    size[i] = sqrt(path->W[i][i]);
    sum += size[i] * fabs(P[i]);
    largest = PS_MAX(largest, size[i] * fabs(P[i]));
  }
  for (int i = 0; i < rows; i++) {
    a[i] = aim[i] + dot(rows, path->W[i], P);
    share[i] = ratio(a[i], fabs(aim[i]) + size[i] * sum);
    if (fabs(share[i]) <= PS_RATE_ROUNDING) a[i] = 0;
  }
  for (int c = 0; c < k; c++) worst = PS_MAX(worst, fabs(share[still[c]]));
  for (int i = 0; i < path->n; i++) {
    const int n = PS_N(i), t = PS_T(i, 0);
    const double beyond = size[t] * (fabs(P[t]) - path->mu[i] * fabs(P[n]));
    if (!path->held[i]) worst = PS_MAX(worst, -share[n]);
    worst = PS_MAX(worst, ratio(beyond, largest));
    worst = PS_MAX(worst, ratio(size[t] * P[t], largest) * share[t]);
  }
  return worst <= PS_MISSED;
}

/* Impulses P and rates a = aim + W P, also where the bodies' rigidity leaves them open, and `moving`
 * where they have to change a velocity; 0: there are none. The step takes what made them. */
static int impulses_at_once(const ps_path *path, const double *aim, int moving, double *P, double *a,
                            ps_step *step) {
  const int n = path->n, rows = PS_SIZE(n);
  int mode[PS_RIGID];
  ps_piece piece[PS_RIGID];
  const ps_piece *taken[PS_RIGID];
  ps_system system;
  double fixed[PS_ROWS], right[PS_ROWS] = {0}, x[PS_ROWS], largest = 0;
  ps_square W;
  memcpy(W, path->W, sizeof W);
  for (int i = 0; i < rows; i++) largest = PS_MAX(largest, W[i][i]);
  if (!(largest > 0)) largest = 1; /* nothing moves */
  for (int i = 0; i < rows && path->singular; i++) W[i][i] += PS_MORE_MOBILITY * largest;
  if (!least_impulses(path, W, aim, moving, P, a, mode)) return 0;
  for (int i = 0; i < n; i++) {
    taken[i] = &piece[i];
    if (mode[i] == PS_APART) apart_piece(&piece[i]);
    else close_piece(mode[i], path->mu[i], P[PS_N(i)] < 0 ? -1 : 1, &piece[i]);
  }
  make_system(n, (double (*)[PS_ROWS])path->W, taken, fixed, &system);
  note_system(&system, step);
  if (!path->singular) return 1;
  /* The limit of ever less mobility added, in the same modes. */
  for (int r = 0; r < system.size; r++) right[r] = -aim[system.row[r]];
  memcpy(P, fixed, sizeof fixed);
  if (system.size) solve_in_range(system.size, system.matrix, right, x);
  extend(&system, x, P);
  for (int i = 0; i < n; i++)
    if (!path->held[i]) P[PS_N(i)] = PS_MAX(P[PS_N(i)], 0);
  if (!is_limit(path, aim, P, system.row, system.size, a)) return 0;
  for (int c = 0; c < system.size; c++) a[system.row[c]] = 0;
  return 1;
}

/* Tells the listener of a step that begins at the velocity v; what it was made of is in it. */
static void tell_step(const ps_path *path, ps_step *step, int kind, const double *v,
                      const double *push, const double *rates) {
  step->kind = kind;
  memcpy(step->v, v, sizeof step->v);
  memcpy(step->push, push, sizeof step->push);
  memcpy(step->rates, rates, sizeof step->rates);
  path->listener(PS_TOLD_STEP, (const double *)step, NULL);
}

/* Sets dP_n/dtau of the contacts that push, the largest 1, by what would stop them at once. */
static void weigh(ps_path *path) {
  double P[PS_ROWS] = {0}, a[PS_ROWS] = {0}, largest = 0;
  ps_step step = {0};
  for (int i = 0; i < path->n; i++) path->weight[i] = 1;
  if (path->n < 2) return;
  if (!impulses_at_once(path, path->v, 0, P, a, &step)) {
    for (int i = 0; i < PS_ROWS; i++) P[i] = step.unknowns = 0;
  }
  if (path->listener) tell_step(path, &step, PS_WEIGHS, path->v, P, a);
  for (int i = 0; i < path->n; i++) {
    if (path->held[i]) P[PS_N(i)] = 0;
    largest = PS_MAX(largest, P[PS_N(i)]);
  }
  for (int i = 0; i < path->n && largest > 0; i++) path->weight[i] = P[PS_N(i)] / largest;
}

/* ---- how the contacts push ---- */

/* dv/dtau, exactly 0 where it is within the rounding of its terms. */
static void rates_of(const ps_path *path, const double *push, double *rates) {
  const int rows = PS_SIZE(path->n);
  for (int i = 0; i < rows; i++) {
    rates[i] = dot(rows, path->W[i], push);
    if (fabs(rates[i]) <= PS_RATE_ROUNDING * terms_of(rows, path->W[i], push)) rates[i] = 0;
  }
}

/* The contact pushes with dP_n/dtau = weight. */
static int pushing_pieces(const ps_path *path, int i, double weight, ps_piece *pieces) {
  const int n = closed_pieces(path->mu[i], path->v[PS_T(i, 0)], 0, pieces);
  for (int k = 0; k < n; k++) give_normal(&pieces[k], weight);
  return n;
}

/* The pieces in which contact i may be at the present velocity. */
static int pieces_of(const ps_path *path, int i, ps_piece *pieces) {
  const double v_n = path->v[PS_N(i)], v_t = path->v[PS_T(i, 0)];
  int n;
  if (path->held[i]) return closed_pieces(path->mu[i], v_t, 1, pieces);
  if (v_n < path->border[i] || path->budget[i] > 0)
    return pushing_pieces(path, i, path->weight[i], pieces);
  n = apart_piece(pieces);
  if (v_n > path->border[i]) return n;
  with_sign(pieces, 0, 1);
  n += closed_pieces(path->mu[i], v_t, 0, pieces + n);
  for (int end = n + pushing_pieces(path, i, 1, pieces + n); n < end; n++)
    with_sign(&pieces[n], 0, -1);
  return n;
}

/* By how much dP/dtau misses the conditions of the pieces it is made of. */
static double missed_by(const ps_path *path, const ps_piece *const *taken, const double *push) {
  const int n = path->n, rows = PS_SIZE(n);
  double worst = -HUGE_VAL, share[PS_ROWS], size = 0;
  for (int i = 0; i < n; i++) size = PS_MAX(size, path->mu[i]);
  for (int i = 0; i < rows; i++)
    share[i] = ratio(dot(rows, path->W[i], push), terms_of(rows, path->W[i], push));
  for (int i = 0; i < n; i++) {
    double normal = push[PS_N(i)], force = path->held[i] ? fabs(normal) : normal;
    double beyond = fabs(push[PS_T(i, 0)]) - path->mu[i] * force;
    if (!path->held[i]) worst = PS_MAX(worst, PS_MAX(-normal, normal - 1));
    if (taken[i]->side) worst = PS_MAX(worst, -taken[i]->side * normal);
    worst = PS_MAX(worst, beyond / (1 + size));
    for (int k = 0; k < taken[i]->unknowns; k++)
      worst = PS_MAX(worst, fabs(share[PS_ROW(i, taken[i]->vanishing[k])]));
    for (int k = 0; k < taken[i]->inequalities; k++)
      worst = PS_MAX(worst, -taken[i]->sign[k] * share[PS_ROW(i, taken[i]->entry[k])]);
  }
  return worst;
}

/* dP/dtau of one piece for each contact; of least norm where rigidity leaves the forces open. The step,
 * or NULL, takes what it is made of. */
static void push_of(const ps_path *path, const ps_piece *const *taken, double *push, ps_step *step) {
  ps_system system;
  double right[PS_ROWS], x[PS_ROWS];
  make_system(path->n, (double (*)[PS_ROWS])path->W, taken, push, &system);
  if (step) {
    memcpy(step->fixed, push, sizeof step->fixed);
    note_system(&system, step);
  }
  if (system.size <= 0) return;
  for (int r = 0; r < system.size; r++)
    right[r] = -dot(PS_SIZE(path->n), path->W[system.row[r]], push);
  least_norm(system.size, system.matrix, right, x);
  extend(&system, x, push);
  /* Exactly 1 marks a full push, which one that only holds is not. */
  for (int i = 0; i < path->n; i++)
    if (taken[i]->unknowns && taken[i]->vanishing[0] == 0 && push[PS_N(i)] == 1)
      push[PS_N(i)] = nextafter(1, 0);
}

/* What is least in the preferred one of several pushes, but for rounding. */
typedef struct {
  double missed, order[3];
} ps_rank;

static int before(const ps_rank *a, const ps_rank *b) {
  for (int i = 0; i < 3; i++)
    if (a->order[i] != b->order[i]) return a->order[i] < b->order[i];
  return 0;
}

/* dP/dtau of the pieces taken and its rank; whether it is admitted. Where `pressing`, whose largest is
 * `size`, the velocities have to change. */
static int candidate(const ps_path *path, const ps_pieces *pieces, const double *pressing, double size,
                     double *push, ps_rank *rank) {
  double rates[PS_ROWS];
  int moves = !pressing;
  push_of(path, pieces->taken, push, NULL);
  memset(rank, 0, sizeof *rank);
  rank->missed = missed_by(path, pieces->taken, push);
  for (int i = 0; i < path->n; i++) {
    if (path->held[i]) continue;
    rank->order[1] += push[PS_N(i)];
    if (pressing) rank->order[0] += push[PS_N(i)] * pressing[i];
  }
  rank->order[0] = rounded_to_nine(rank->order[0] / size);
  rank->order[1] = rounded_to_nine(rank->order[1]);
  rank->order[2] = rounded_to_nine(dot(PS_SIZE(path->n), push, push));
  if (!(rank->missed <= PS_MISSED)) return 0;
  if (pressing) rates_of(path, push, rates);
  for (int i = 0; i < PS_SIZE(path->n) && !moves; i++) moves = rates[i] != 0;
  return moves;
}

/* Whether two pushes have the same dv/dtau but for rounding. */
static int same_rates(const ps_path *path, const double *a, const double *b) {
  for (int i = 0; i < PS_SIZE(path->n); i++) {
    double change = 0, terms = 0;
    for (int j = 0; j < PS_SIZE(path->n); j++) {
      change += path->W[i][j] * (a[j] - b[j]);
      terms += fabs(path->W[i][j]) * PS_MAX(fabs(a[j]), fabs(b[j]));
    }
    if (fabs(change) > PS_EQUAL_RATES * terms) return 0;
  }
  return 1;
}

/* dP/dtau: of several possible ones that of least normal force. Where `pressing`, for an impact
 * without collision: b_n of each contact; the velocities then have to change, and contacts with
 * b_n < 0 push first. 0 where no such impact is possible. The step takes what it is made of. */
static int choose_push(const ps_path *path, const double *pressing, double *push, ps_step *step) {
  ps_pieces pieces;
  int possible = 0, any = 0, taken[PS_RIGID] = {0}, closest[PS_RIGID] = {0};
  double now[PS_ROWS], nearest[PS_ROWS] = {0}, size = 0;
  ps_rank best = {0}, near = {0}, rank;
  for (int i = 0; i < path->n && pressing; i++)
    if (!path->held[i]) size = PS_MAX(size, fabs(pressing[i]));
  if (size == 0) size = 1;
  for (int i = 0; i < path->n; i++) pieces.count[i] = pieces_of(path, i, pieces.offered[i]);
  take_first(path->n, &pieces);
  do {
    const int admitted = candidate(path, &pieces, pressing, size, now, &rank);
    if (admitted && (!possible || before(&rank, &best))) {
      possible = 1;
      best = rank;
      memcpy(push, now, sizeof now);
      memcpy(taken, pieces.at, sizeof taken);
    }
    if (!any || rank.missed < near.missed || (rank.missed == near.missed && before(&rank, &near))) {
      any = 1;
      near = rank;
      memcpy(nearest, now, sizeof now);
      memcpy(closest, pieces.at, sizeof closest);
    }
  } while (take_next(path->n, &pieces));
  /* Without guides one exists, by Kakutani's theorem: where rounding hides it, the nearest is taken. */
  const int exists = !pressing && !path->guides;
  if (!possible && exists) memcpy(push, nearest, sizeof nearest);
  if (path->listener && (possible || exists)) {
    step->alone = 1;
    do {
      const int admitted = possible && candidate(path, &pieces, pressing, size, now, &rank);
      if (admitted && !same_rates(path, now, push)) step->alone = 0;
    } while (take_next(path->n, &pieces));
    for (int i = 0; i < path->n; i++)
      pieces.taken[i] = &pieces.offered[i][possible ? taken[i] : closest[i]];
    push_of(path, pieces.taken, now, step);
  }
  return possible || exists;
}

/* ---- one piece ---- */

/* Length after which a value that is not 0 becomes 0; infinite where it does not. */
static double crossing(double value, double rate) {
  return value * rate < 0 ? -value / rate : HUGE_VAL;
}

/* Whether contact i has a normal force. */
static int rubs(const ps_path *path, int i, const double *push) {
  return path->held[i] ? push[PS_N(i)] != 0 : push[PS_N(i)] > 0;
}

/* Whether contact i compresses; also where it pushes fully at v_n = 0 to no effect. */
static int compresses(const ps_path *path, int i, const double *push, const double *rates) {
  if (path->held[i]) return 0;
  double v_n = path->v[PS_N(i)], a_n = rates[PS_N(i)];
  int begins = a_n == 0 && push[PS_N(i)] == 1 && path->budget[i] == 0;
  return v_n < 0 || (v_n == 0 && (a_n < 0 || begins));
}

/* Length at which contact i has given back its restitution. */
static double spent(const ps_path *path, int i, const double *push, const double *rates) {
  double v_n = path->v[PS_N(i)], budget = path->budget[i], force = push[PS_N(i)];
  if (budget == 0 || force == 0 || compresses(path, i, push, rates)) return HUGE_VAL;
  if (path->measure == PS_BY_IMPULSE) return budget / force;
  /* v_n P + a_n P^2/2 = budget, without the cancellation of the usual root. */
  double square = v_n * v_n + 2 * rates[PS_N(i)] * budget / force;
  return square > 0 ? 2 * budget / force / (v_n + sqrt(square)) : HUGE_VAL;
}

/* Length at which the contacts have given back all energy they took. */
static double energy_is_back(const ps_path *path, const double *push, const double *rates) {
  double power = dot(PS_SIZE(path->n), push, path->v), slope = dot(PS_SIZE(path->n), push, rates);
  double square = power * power - 2 * slope * path->work;
  if (path->measure != PS_BY_IMPULSE || !(path->work < 0 && square > 0 && (slope > 0 || power > 0)))
    return HUGE_VAL;
  double root = sqrt(square);
  return power > 0 ? -2 * path->work / (power + root) : (root - power) / slope;
}

static double restitution_after(const ps_path *path, int i, double length, double twice_mean,
                                const double *push, const double *rates) {
  double budget = path->budget[i], impulse = push[PS_N(i)] * length;
  if (path->measure == PS_BY_VELOCITY) return 0;
  const int kinetic = path->measure == PS_BY_IMPULSE;
  double given_back = kinetic ? impulse : impulse * twice_mean / 2;
  if (compresses(path, i, push, rates))
    return budget + path->share[i] * (kinetic ? given_back : -given_back);
  return budget > 0 ? PS_MAX(0, budget - given_back) : 0;
}

/* The border of a normal velocity, or 0 of a slip. */
static double at_rest(const ps_path *path, int i) {
  return PS_AXIS_OF(i) ? 0 : path->border[PS_CONTACT_OF(i)];
}

/* Follows the present piece over `length`; what vanishes there vanishes exactly. */
static void follow_piece(ps_path *path, const double *push, const double *rates, double length) {
  const int n = path->n;
  double after[PS_ROWS], budget[PS_RIGID] = {0}, reached = length * (1 + PS_COINCIDENT), work = 0;
  int small = 1;
  for (int i = 0; i < n; i++) {
    const int a = PS_N(i), t = PS_T(i, 0);
    /* What leaves the border under a push leaves it under a full one, and keeps it. */
    if (path->v[a] == path->border[i] && path->budget[i] == 0) path->weight[i] = 1;
    after[a] = path->v[a] + rates[a] * length;
    after[t] = path->v[t] + rates[t] * length;
    budget[i] = restitution_after(path, i, length, path->v[a] + after[a], push, rates);
    if (spent(path, i, push, rates) <= reached) budget[i] = 0;
    if (crossing(path->v[a] - path->border[i], rates[a]) <= reached) after[a] = path->border[i];
    if (rubs(path, i, push) && crossing(path->v[t], rates[t]) <= reached) after[t] = 0;
  }
  const int lapses = energy_is_back(path, push, rates) <= reached;
  for (int i = 0; i < PS_SIZE(n); i++) {
    double part = push[i] * length * (path->v[i] + after[i]) / 2;
    path->impulses[i] += push[i] * length;
    path->works[i] += part;
    work += part;
    if (rubs(path, PS_CONTACT_OF(i), push) && fabs(after[i] - at_rest(path, i)) > PS_ALL_REST_SPEED)
      small = 0;
  }
  for (int i = 0; i < PS_SIZE(n); i++) {
    /* Contacts that do not push may come to rest with the others, of one body. */
    const int pushes = rubs(path, PS_CONTACT_OF(i), push);
    const double near = pushes && small ? PS_ALL_REST_SPEED : PS_REST_SPEED;
    const double rest = pushes ? at_rest(path, i) : 0;
    path->v[i] = fabs(after[i] - rest) <= near ? rest : after[i];
  }
  double least = path->measure == PS_BY_IMPULSE ? PS_REST_SPEED : PS_REST_SPEED * PS_REST_SPEED;
  for (int i = 0; i < n; i++) path->budget[i] = lapses || budget[i] <= least ? 0 : budget[i];
  path->work = lapses ? 0 : path->work + work;
}

/* Length of the present piece, infinite where it has no end, and in the step what ends it. */
static double piece_length(const ps_path *path, const double *push, const double *rates,
                           ps_step *step) {
  step->length = HUGE_VAL;
  for (int end = PS_BORDER; end <= PS_SPENT; end++)
    for (int i = 0; i < (end == PS_ENERGY_BACK ? 1 : path->n); i++) {
      const int n = PS_N(i), t = PS_T(i, 0);
      double length = HUGE_VAL;
      if (end == PS_BORDER) length = crossing(path->v[n] - path->border[i], rates[n]);
      if (end == PS_ENERGY_BACK) length = energy_is_back(path, push, rates);
      if (end == PS_SLIP_ZERO && rubs(path, i, push)) length = crossing(path->v[t], rates[t]);
      if (end == PS_SPENT) length = spent(path, i, push, rates);
      if (!(length < step->length)) continue;
      step->length = length;
      step->end = end;
      step->contact = i;
    }
  return step->length;
}

/* Newton's law for all contacts at once from the present velocity with e of each, or NULL for a stop, by
 * which the velocity has to change; 0 without a solution. Friction opposes the slip after it. */
static int take_at_once(ps_path *path, const double *e) {
  double aim[PS_ROWS] = {0}, P[PS_ROWS] = {0}, a[PS_ROWS] = {0}, rebound[PS_ROWS];
  ps_step step = {0};
  for (int i = 0; i < PS_SIZE(path->n); i++) {
    rebound[i] = PS_AXIS_OF(i) || !e ? 0 : -e[PS_CONTACT_OF(i)] * path->v[i];
    aim[i] = path->v[i] - rebound[i];
  }
  if (!impulses_at_once(path, aim, !e, P, a, &step)) return 0;
  for (int i = 0; i < path->n; i++) step.e[i] = e ? e[i] : NAN;
  if (path->listener) tell_step(path, &step, PS_ALL_AT_ONCE, path->v, P, a);
  for (int i = 0; i < PS_SIZE(path->n); i++) {
    double after = a[i] + rebound[i];
    path->impulses[i] += P[i];
    path->works[i] += P[i] * (path->v[i] + after) / 2;
    path->v[i] = after;
  }
  return 1;
}

/* Tells the listener that a path begins. */
static void tell_course(const ps_path *path) {
  ps_course course = {.n = path->n, .mass = path->mass, .speed = path->speed};
  if (!path->listener) return;
  memcpy(course.W, path->W, sizeof course.W);
  memcpy(course.mu, path->mu, sizeof course.mu);
  memcpy(course.v, path->start, sizeof course.v);
  memcpy(course.border, path->border, sizeof course.border);
  path->listener(PS_TOLD_COURSE, (const double *)&course, NULL);
}

/* The same for the whole impact, in place of the path. */
static int restart_at_once(ps_path *path) {
  for (int i = 0; i < PS_SIZE(path->n); i++) {
    path->v[i] = path->start[i];
    path->impulses[i] = path->works[i] = 0;
  }
  tell_course(path);
  return take_at_once(path, path->share);
}

static int collides_anywhere(const ps_path *path) {
  int any = 0;
  for (int i = 0; i < path->n; i++) any |= path->v[PS_N(i)] < 0;
  return any;
}

/* Follows the path to where no contact pushes; 0 where it never gets there. */
static int follow_path(ps_path *path, const double *pressing) {
  double push[PS_ROWS] = {0}, rates[PS_ROWS] = {0}, v[PS_ROWS];
  int collides = collides_anywhere(path), first = 1;
  tell_course(path);
  if (collides) weigh(path);
  for (int piece = 0; piece < PS_PIECES; piece++) {
    ps_step step = {0};
    if (!choose_push(path, first && !collides ? pressing : NULL, push, &step)) {
      /* Friction of a guide leaves no slow way: it stops the slip at once. */
      if (!path->guides || !take_at_once(path, NULL)) return 0;
      first = 0;
      continue;
    }
    first = 0;
    int pushes = 0, ended = 1;
    for (int i = 0; i < PS_SIZE(path->n); i++) pushes |= push[i] != 0;
    if (!pushes) {
      for (int i = 0; i < path->n; i++) ended &= path->v[PS_N(i)] >= path->border[i];
      if (ended) return 1;
      weigh(path);
      continue;
    }
    rates_of(path, push, rates);
    if (!(piece_length(path, push, rates, &step) < HUGE_VAL)) return 0;
    memcpy(v, path->v, sizeof v);
    for (int i = 0; i < path->n; i++) {
      step.budget[i] = path->budget[i];
      step.compresses[i] = compresses(path, i, push, rates);
      step.rubs[i] = rubs(path, i, push);
    }
    follow_piece(path, push, rates, step.length);
    if (!path->listener) continue;
    memcpy(step.after, path->v, sizeof step.after);
    memcpy(step.budget_after, path->budget, sizeof step.budget_after);
    step.work = path->work;
    tell_step(path, &step, PS_STRAIGHT, v, push, rates);
  }
  return 0;
}

/* Whether the mobility, of unit diagonal, has a singular value that is zero. */
static int is_singular(int n, ps_square W) {
  ps_square a, turn;
  for (int i = 0; i < PS_SIZE(n); i++)
    for (int j = 0; j < PS_SIZE(n); j++) {
      double size = sqrt(W[i][i]) * sqrt(W[j][j]);
      a[i][j] = size > 0 ? W[i][j] / size : 0;
    }
  orthogonal_rows(PS_SIZE(n), a, turn);
  for (int i = 0; i < PS_SIZE(n); i++)
    if (!(sqrt(dot(PS_SIZE(n), a[i], a[i])) > PS_SINGULAR_MOBILITY)) return 1;
  return 0;
}

/* The impact of n closed contacts, those `held` (n) from both sides: W (2n, 2n), mu (n), v_n and v_t (2n)
 * for an impact without collision b_n (n), and e (n). Along its path, or by the `final_slip` at once.
 * Writes velocities after it, impulses, and works of the normal and tangential impulses, each of shape
 * (2n); tells the listener, or NULL. 0 where it jams. */
static int follow_impact(int n, const double *W, const double *mu, const double *v, const int *held,
                         const double *pressing, int measure, int power, int final_slip,
                         const double *e, double *velocity, double *impulse, double *work,
                         ps_listener listener) {
  ps_path path;
  double largest = 0, fastest = 0;
  int mass, speed, pushing = 0, collides, ended;
  memset(&path, 0, sizeof path);
  for (int i = 0; i < PS_SIZE(n); i++) {
    largest = PS_MAX(largest, fabs(W[i * PS_SIZE(n) + i]));
    fastest = PS_MAX(fastest, fabs(v[i]));
  }
  /* Powers of two leave every digit. */
  frexp(largest, &mass);
  frexp(fastest, &speed);
  path.n = n;
  path.measure = measure;
  path.held = held;
  path.mass = mass;
  path.speed = speed;
  path.listener = listener;
  for (int i = 0; i < n; i++) path.guides |= held[i];
  for (int i = 0; i < PS_SIZE(n); i++) {
    for (int j = 0; j < PS_SIZE(n); j++) path.W[i][j] = ldexp(W[i * PS_SIZE(n) + j], -mass);
    path.v[i] = path.start[i] = ldexp(v[i], -speed);
  }
  for (int i = 0; i < n; i++) {
    path.mu[i] = mu[i];
    path.share[i] = e[i];
    for (int k = 1; k < power; k++) path.share[i] *= e[i];
    double rebound = -path.share[i] * path.v[PS_N(i)];
    path.border[i] = measure == PS_BY_VELOCITY && rebound > PS_REST_SPEED ? rebound : 0;
    path.weight[i] = 1;
  }
  path.singular = (n > 1 || path.guides || final_slip) && is_singular(n, path.W);
  collides = collides_anywhere(&path);
  if (final_slip) {
    tell_course(&path);
    ended = take_at_once(&path, collides ? path.share : NULL);
  } else
    ended = follow_path(&path, pressing);
  for (int i = 0; i < n; i++) pushing += !held[i] && path.impulses[PS_N(i)] != 0;
  if (measure == PS_BY_VELOCITY && !final_slip && pushing > 1 && collides)
    ended = restart_at_once(&path);
  for (int i = 0; i < PS_SIZE(n); i++) {
    /* Of a contact that others held, rounding may be left. */
    double rest = at_rest(&path, i);
    velocity[i] = ldexp(fabs(path.v[i] - rest) <= PS_REST_SPEED ? rest : path.v[i], speed);
    impulse[i] = ldexp(path.impulses[i], speed - mass);
    work[i] = ldexp(path.works[i], 2 * speed - mass);
  }
  return ended;
}
#endif
