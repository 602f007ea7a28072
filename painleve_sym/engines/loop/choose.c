/* Parts whose local modes are data: where a transition chooses, every combination of their
 * alternatives is tested, and one of those that satisfy the tests is entered. */

#if PS_NPART
/* Parts of the terms that an inequality is made of: what counts as zero, and what a derivative must
 * add to it over a step to count. */
static const double PS_ZERO_TERMS = 1e-12, PS_ZERO_SLOPE = 1e-10;
/* A derivative that rounding of the states changes by this part says nothing. */
static const double PS_ROUNDED = 1e-3;
/* Motions whose rates differ by less than this part are one and the same. */
static const double PS_SAME_MOTION = 1e-8;

/* Errors of a state, by its tolerance, below which it is at rest. */
static const double PS_REST_ERRORS = 10;

static double first_step(ps_run *s, const ps_options *o);
static int guard_side(double g, double d, double d2, double zero, double moment, int departs);

/* Whether rounding of the states decides what a derivative is; `near` is that of states rounded otherwise. */
static int rounding_decides(double derivative, double near) {
  return fabs(near - derivative) >= PS_ROUNDED * fabs(derivative);
}

/* How the tests of the mode hold in the memory of the run: each is positive, or zero but for rounding
 * with the first derivative that is not zero positive; one that vanishes has none that is not zero. By
 * the measure by which guards are armed they last: none of these then fires at once. Idle: what should
 * begin stays zero. Where they fail, `missed` is by how much, in parts of their scales. It ends where
 * they fail by rates alone: guards would be armed, though values are no more than rounding. */
enum { PS_FAILS, PS_HOLDS, PS_LASTS, PS_IDLE = 4, PS_ENDS = 8, PS_POSITIVE = 16 };

static int consistent(ps_run *s, const ps_options *o, double *missed) {
  const ps_mode *m = &PS_MODES[s->mode];
  /* C99 has no arrays without an element. */
  double v[PS_NTEST + 1], d[PS_NTEST + 1], d2[PS_NTEST + 1], scale[PS_NTEST + 1];
  double x_near[PS_NX], near[4][PS_NTEST + 1] = {{0}}, *d_near = near[1], *d2_near = near[2];
  double *res[4] = {v, d, d2, scale}, *res_near[4] = {near[0], d_near, d2_near, near[3]};
  int lasts = 1, idle = 0, ends = 1, positive = 0, rounded = 0;
  s->variant = &PS_VARIANTS[s->mode];
  field(s, s->x, s->k[0]);
  const double h = first_step(s, o);
  *missed = HUGE_VAL;
  if (!isfinite(h)) return 0;
  *missed = 0;
  call(s, m->tests, s->x, res);
  for (int i = 0; i < PS_NX; i++) {
    const double rounding = PS_ZERO_TERMS * o->atol[i] / o->rtol;
    x_near[i] = s->x[i] == 0 ? 0 : s->x[i] + (i % 2 ? rounding : -rounding);
  }
  for (int j = 0; j < m->tested; j++) {
    if (!isfinite(v[j])) *missed = HUGE_VAL;
    /* Of motions with as many open parts, the policy takes one by the sign of this value. */
    if (m->roles[j] == 'r') {
      positive |= v[j] > 0;
      continue;
    }
    double decides = v[j], slope = PS_ZERO_SLOPE * scale[j];
    if (!(fabs(v[j]) > PS_ZERO_TERMS * scale[j] + PS_ZERO_TIME * fabs(h * d[j]))) {
      if (!rounded && (d[j] != 0 || d2[j] != 0)) {
        call(s, m->tests, x_near, res_near);
        rounded = 1;
      }
      const double first = rounding_decides(d[j], d_near[j]) ? 0 : h * d[j];
      const double second = rounding_decides(d2[j], d2_near[j]) ? 0 : 0.5 * h * h * d2[j];
      if (!(fabs(v[j]) > PS_ZERO_TERMS * scale[j] + PS_ZERO_TIME * fabs(first)))
        decides = fabs(first) > slope ? first : fabs(second) > slope ? second : 0;
    }
    const int stays = !s->exists && m->roles[j] == 'b' && decides == 0 && scale[j] > 0;
    idle |= stays;
    if (m->roles[j] == 'v') decides = -fabs(decides);
    if (decides < 0) *missed = PS_MAX(*missed, -decides / scale[j]);
    if (m->roles[j] == 'v' && decides < 0) ends = 0;
    if (stays || m->roles[j] == 'v') continue;
    const int side = guard_side(v[j], d[j], d2[j], PS_ZERO_TIME * h, 0, 0);
    if (side < 0) lasts = 0;
    if (decides < 0) ends &= m->roles[j] == 'h' && side > 0;
  }
  if (*missed > 0) return ends ? PS_ENDS : PS_FAILS;
  return (lasts ? PS_LASTS : PS_HOLDS) | (idle ? PS_IDLE : 0) | (positive ? PS_POSITIVE : 0);
}

/* Whether a memory was chosen before at this instant. A motion that ends where it begins is not the one
 * that lasts, though rounding hides which other one is. */
static int entered_before(const ps_run *s, const double *z) {
  const int count = s->t_entered == s->t_base + s->t ? PS_MIN(s->choices, PS_ENTERED) : 0;
  for (int k = 0; k < count; k++)
    if (!memcmp(s->entered[k], z, PS_OWNED_SIZE * sizeof(double))) return 1;
  return 0;
}

static void note_entered(ps_run *s, const double *z) {
  const double t = s->t_base + s->t;
  if (s->t_entered != t) s->choices = 0;
  s->t_entered = t;
  memcpy(s->entered[s->choices++ % PS_ENTERED], z, sizeof s->entered[0]);
}

static double largest_rate(const double *rates) {
  double size = 0;
  for (int i = 0; i < PS_NX; i++) size = PS_MAX(size, fabs(rates[i]));
  return size;
}

/* Whether rates are those of one motion; less than `rounding` they are not known to. */
static int same_motion(const double *a, const double *b, double rounding) {
  double difference = 0, same = PS_SAME_MOTION * largest_rate(a);
  for (int i = 0; i < PS_NX; i++) difference = PS_MAX(difference, fabs(a[i] - b[i]));
  return difference <= PS_MAX(same, rounding);
}

/* Goes to the next combination of alternatives, in the end to the first one again. */
static void next_combination(const int *count, int *at) {
  for (int p = PS_NPART - 1; p >= 0 && ++at[p] == count[p]; p--) at[p] = 0;
}

/* Offers each part what is possible, or, where a combination is given, what that has or becomes where
 * it is idle. Returns how many combinations there are. */
static int offer(const double *condition, const int *given, int offered[][PS_NALT], int *count) {
  int combinations = 1;
  for (int p = 0, first = 0; p < PS_NPART; first += PS_OFFERED[p++]) {
    count[p] = 0;
    for (int a = first; a < first + PS_OFFERED[p]; a++) {
      const int of = PS_REST_OF[a] < 0 ? -1 : first + PS_REST_OF[a];
      const int wanted = given ? a == given[p] || of == given[p] : of < 0;
      if (wanted && condition[a] > 0) offered[p][count[p]++] = a;
    }
    combinations *= count[p];
  }
  return combinations;
}

/* Whether all forces are given: no rigid contact can be closed. */
static int forces_are_given(int offered[][PS_NALT], const int *count) {
  int given = 1;
#ifdef PS_IMPACTS
  for (int k = 0; k < PS_RIGID; k++) {
    const int p = PS_RIGID_CONTACT[k];
    given &= count[p] == 1 && PS_IS_OPEN[offered[p][0]];
  }
#endif
  (void)offered;
  (void)count;
  return given;
}

/* Writes the memory of a combination into that of the run. */
static void take_up(ps_run *s, const int *taken, double memory[][PS_OWNED_SIZE]) {
  for (int p = 0; p < PS_NPART; p++)
    for (int i = PS_OWNED[p]; i < PS_OWNED[p + 1]; i++) s->z[i] = memory[taken[p]][i];
}

/* Puts the memory z of an idle combination at rest where that makes one that is not idle. */
static void rest(ps_run *s, const ps_options *o, const double *condition,
                 double memory[][PS_OWNED_SIZE], const int *taken, double *z) {
  int offered[PS_NPART][PS_NALT], count[PS_NPART], at[PS_NPART] = {0}, now[PS_NPART];
  double missed;
  const int combinations = offer(condition, taken, offered, count);
  for (int k = 0; k < combinations; k++) {
    for (int p = 0; p < PS_NPART; p++) now[p] = offered[p][at[p]];
    take_up(s, now, memory);
    const int held = consistent(s, o, &missed);
    if (held && !(held & (PS_IDLE | PS_ENDS))) {
      memcpy(z, s->z, PS_OWNED_SIZE * sizeof(double));
      return;
    }
    next_combination(count, at);
  }
}

/* Puts into z the memory of a combination of the motion with these rates that lasts, with as many parts
 * in what they prefer; 0 where there is none. */
static int lasting(ps_run *s, const ps_options *o, const double *condition,
                   double memory[][PS_OWNED_SIZE], const double *rates, double rounding, int most, double *z) {
  int offered[PS_NPART][PS_NALT], count[PS_NPART], at[PS_NPART] = {0}, now[PS_NPART];
  double missed;
  const int combinations = offer(condition, NULL, offered, count);
  for (int k = 0; k < combinations; k++) {
    int preferred = 0;
    for (int p = 0; p < PS_NPART; p++) preferred += PS_IS_PREFERRED[now[p] = offered[p][at[p]]];
    take_up(s, now, memory);
    if (preferred == most && consistent(s, o, &missed) == PS_LASTS && same_motion(s->k[0], rates, rounding)) {
      memcpy(z, s->z, PS_OWNED_SIZE * sizeof(double));
      return 1;
    }
    next_combination(count, at);
  }
  return 0;
}

/* Chooses the local modes after a reset to x and z, both of which may be changed. Of several motions
 * the policy takes the one with most (1) or fewest (-1) open parts, or none (0); where that leaves a
 * choice, one with most parts in what they prefer. Where that does not last, another combination of the
 * same motion may. Of a motion that is idle, parts rest where that makes one that is not. Returns how
 * many such motions there are. */
static int choose(ps_run *s, const ps_options *o, double *x, double *z) {
  double condition[PS_NALT], memory[PS_NALT][PS_OWNED_SIZE], x_before[PS_NX], z_before[PS_NZ];
  double best_rate[PS_NX] = {0}, nearest = HUGE_VAL, near[PS_NZ], missed = 0, span = 0;
  double *res[2] = {condition, &memory[0][0]};
  int offered[PS_NPART][PS_NALT], count[PS_NPART], at[PS_NPART] = {0}, now[PS_NPART], taken[PS_NPART];
  int motions = 0, best = -1, repeats = 1, most = 0, idle = 0, some = 0, lasts = 1;
  memcpy(x_before, s->x, sizeof x_before);
  memcpy(z_before, s->z, sizeof z_before);
  for (int i = 0; i < PS_NREST; i++)
    if (fabs(x[PS_REST[i]]) <= PS_REST_ERRORS * o->atol[PS_REST[i]]) x[PS_REST[i]] = 0;
  memcpy(s->x, x, sizeof x_before);
  memcpy(s->z, z, sizeof z_before);
  call(s, PS_ALTERNATIVES, x, res);
  const int combinations = offer(condition, NULL, offered, count);
  s->exists = forces_are_given(offered, count);
  for (int k = 0; k < combinations; k++) {
    int rank = 0, preferred = 0;
    for (int p = 0; p < PS_NPART; p++) {
      now[p] = offered[p][at[p]];
      rank += PS_IS_OPEN[now[p]];
      preferred += PS_IS_PREFERRED[now[p]];
    }
    take_up(s, now, memory);
    rank = PS_POLICY < 0 ? PS_NPART - rank : rank;
    const int held = combinations == 1 ? PS_HOLDS : consistent(s, o, &missed);
    if (combinations > 1) span = PS_MAX(span, largest_rate(s->k[0]));
    const int left = !memcmp(s->z, z_before, PS_OWNED_SIZE * sizeof(double));
    const int again = s->exists && (left || entered_before(s, s->z));
    if (held && held != PS_ENDS) {
      rank = 2 * rank + (held & PS_POSITIVE ? PS_POLICY > 0 : PS_POLICY < 0);
      /* Among those that differ by rounding alone, one that lasts; last the combination just left. */
      rank = 3 * (PS_NPART + 1) * (2 * rank + !(left || again)) + 3 * preferred;
      rank += left || again ? 0 : held & (PS_HOLDS | PS_LASTS);
      repeats &= again;
      if (preferred > most) motions = 0;
      most = PS_MAX(most, preferred);
      /* Rates of an idle one are those of others but for rounding. */
      some |= held & PS_IDLE;
      if (preferred == most && !(held & PS_IDLE))
        motions += !motions || !same_motion(s->k[0], best_rate, 0);
      if (rank > best) {
        best = rank;
        idle = held & PS_IDLE;
        lasts = combinations == 1 || held & PS_LASTS;
        memcpy(best_rate, s->k[0], sizeof best_rate);
        memcpy(z, s->z, sizeof z_before);
        memcpy(taken, now, sizeof taken);
      }
    } else if (!again && (s->exists || held) && missed < nearest) {
      nearest = missed;
      memcpy(near, s->z, sizeof near);
    }
    next_combination(count, at);
  }
  if (!s->exists && !lasts &&
      lasting(s, o, condition, memory, best_rate, PS_ZERO_TERMS * span, most, z))
    idle = 0;
  if (idle) rest(s, o, condition, memory, taken, z);
  motions = motions ? motions : some > 0;
  memcpy(s->x, x_before, sizeof x_before);
  memcpy(s->z, z_before, sizeof z_before);
  if ((!motions || (s->exists && repeats)) && nearest < HUGE_VAL) {
    /* Forces that are all given leave one motion: where rounding hides it, the nearest is taken. Of
     * others one that ends in no time. */
    memcpy(z, near, sizeof near);
    motions = 1;
  }
  s->repeats = motions && entered_before(s, z);
  if (motions) note_entered(s, z);
  return PS_POLICY == 0 && motions > 1 ? 0 : motions;
}
#endif
