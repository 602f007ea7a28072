/* Impacts of rigid contacts within a run: which contacts take part, the state after, and the end of
 * bounces that have died out. */

#ifdef PS_IMPACTS
#define PS_CONTACT_ROWS PS_SIZE(PS_CONTACTS)
enum { PS_GAP, PS_GAP_RATE, PS_SLIP };

/* Of the scale of a gap and of its rate: contacts that touch down together do so to this part. */
static const double PS_TOUCHING = 1e-10;
/* Gap and normal speed at which bounces have died out, in parts of the state's scale; the speed also in
 * parts of that which the free acceleration gives in the time so far, since a run that starts all but at
 * rest has a small scale. */
static const double PS_SETTLED = 1e-9;
/* Numbers of touchdowns whose time, taken together, may shrink from each to the next. */
static const int PS_WINDOWS[] = {1, 2, 3, 5, 8};

/* Numbers of all contacts at a state; matrices by columns. */
typedef struct {
  double W[PS_CONTACT_ROWS * PS_CONTACT_ROWS], load[PS_CONTACT_ROWS];
  double directions[PS_SPEEDS * PS_CONTACT_ROWS], mu[PS_CONTACTS], drive[PS_CONTACT_ROWS];
  double velocity[PS_CONTACT_ROWS], e[PS_RIGID];
} ps_contact_numbers;

/* What a listener hears of an impact or a closing: the contacts and rows that take part, whether it is the
 * `first` event of its stretch of motion or else the contact of the event that it comes `after`, all
 * impulses, state and memory. */
typedef struct {
  double n, rows, first, after, contact[PS_RIGID], row[PS_CONTACT_ROWS], impulses[PS_CONTACT_ROWS];
  double before[PS_NX], memory[PS_NZ + 1];
} ps_change;

static void contact_numbers_of(ps_run *s, const double *x, ps_contact_numbers *c) {
  double *res[7] = {c->W, c->load, c->directions, c->mu, c->drive, c->velocity, c->e};
  call(s, PS_IMPACTS, x, res);
}

/* The state that is the velocity of a row. */
static int rate_state(int row) {
  return PS_CONTACT_STATES[PS_CONTACT_OF(row)][PS_GAP_RATE + PS_AXIS_OF(row)];
}

static double state_scale(const ps_options *o, int i) { return o->atol[i] / o->rtol; }

/* Whether touchdowns of several contacts shrink towards a limit that is reached at the last one. The
 * bounces of one contact are a geometric series; those of several take turns, and only windows of
 * them, taken together, shrink steadily. */
static int touchdowns_accumulate(const ps_run *s) {
  for (size_t w = 0; w < sizeof PS_WINDOWS / sizeof *PS_WINDOWS; w++) {
    const int size = PS_WINDOWS[w];
    double length[8];
    int shrinks = s->touchdowns > PS_SHRINKING * size;
    for (int i = 0; i < PS_SHRINKING && shrinks; i++) {
      length[i] = s->touchdown[i * size] - s->touchdown[(i + 1) * size];
      shrinks = i == 0 || length[i - 1] < length[i];
    }
    if (!shrinks) continue;
    double first = length[0] / length[1], second = length[1] / length[2];
    double ratio = PS_MAX(first, second);
    if (length[0] * ratio / (1 - ratio) < PS_REMAINDER * s->touchdown[0]) return 1;
  }
  return 0;
}

static void note_touchdown(ps_run *s, double t) {
  memmove(s->touchdown + 1, s->touchdown, (PS_TOUCHDOWNS - 1) * sizeof *s->touchdown);
  s->touchdown[0] = t;
  s->touchdowns++;
}

/* Velocities and work of the drives after impulses (2 n) of the contacts. */
static void push_contacts(const ps_contact_numbers *c, const double *impulses, double *x) {
  double velocity[PS_CONTACT_ROWS], driven = 0;
  for (int i = 0; i < PS_CONTACT_ROWS; i++) {
    velocity[i] = x[rate_state(i)] + dot(PS_CONTACT_ROWS, c->W + i * PS_CONTACT_ROWS, impulses);
    driven += c->drive[i] * impulses[i];
  }
  for (int q = 0; q < PS_SPEEDS; q++) {
    double change = 0;
    for (int i = 0; i < PS_CONTACT_ROWS; i++)
      change += c->directions[i * PS_SPEEDS + q] * impulses[i];
    x[PS_SPEED[q]] += change;
  }
  /* Last, since a generalised velocity may be that of a contact. */
  for (int i = 0; i < PS_CONTACT_ROWS; i++) x[rate_state(i)] = velocity[i];
  if (PS_WORKS[2] >= 0) x[PS_WORKS[2]] -= driven;
}

/* Impulses (2 n) of least norm in `count` rows that make the velocities there vanish: those of the
 * coordinates, from which the states of the contacts differ by the error of the integration. What was
 * left would move a body at rest. */
static void stop_rows(const ps_contact_numbers *c, int count, const int *row, double *impulses) {
  ps_square W;
  double P[PS_ROWS] = {0}, stop[PS_ROWS] = {0};
  for (int i = 0; i < count; i++) {
    for (int j = 0; j < count; j++) W[i][j] = c->W[row[i] * PS_CONTACT_ROWS + row[j]];
    stop[i] = -c->velocity[row[i]];
  }
  least_norm(count, W, stop, P);
  for (int i = 0; i < PS_CONTACT_ROWS; i++) impulses[i] = 0;
  for (int i = 0; i < count; i++) impulses[row[i]] = P[i];
}

/* Books the energy that x has lost since it was `before` as lost in contacts. */
static void book_loss(ps_run *s, const double *before, double *x) {
  double now[PS_ENERGIES], then[PS_ENERGIES], loss = 0;
  if (!memcmp(before, x, sizeof s->x)) return;
  energies(s, before, then);
  energies(s, x, now);
  for (int i = 0; i < PS_ENERGIES; i++) loss += then[i] - now[i];
  x[PS_WORKS[0]] += loss;
}

/* Tells a listener what changed the state `before`, and lets it add to x. */
static void tell_change(const ps_run *s, ps_listener listener, int what, int n, const int *contact,
                        int rows, const int *row, const double *impulses, const double *before,
                        double *x) {
  ps_change change = {.n = n, .rows = rows, .first = s->last_kind < 0, .after = s->last_contact};
  if (!listener) return;
  for (int i = 0; i < n; i++) change.contact[i] = contact[i];
  for (int i = 0; i < rows; i++) change.row[i] = row[i];
  memcpy(change.impulses, impulses, sizeof change.impulses);
  memcpy(change.before, before, sizeof change.before);
  memcpy(change.memory, s->z, sizeof change.memory);
  listener(what, (const double *)&change, x);
}

/* Gives a row the velocity that the coordinates have after impulses, 0 where it is rounding. */
static void move_along(const ps_contact_numbers *c, int row, const double *impulses, double *x) {
  double velocity = c->velocity[row], terms = fabs(velocity);
  for (int i = 0; i < PS_CONTACT_ROWS; i++) {
    const double change = c->W[row * PS_CONTACT_ROWS + i] * impulses[i];
    velocity += change;
    terms += fabs(change);
  }
  x[rate_state(row)] = fabs(velocity) > PS_RATE_ROUNDING * terms ? velocity : 0;
}

/* Closes contacts whose gap and normal velocity are all but 0; those at rest, guides too, are among
 * them and stay closed. A contact with friction whose slip the normal impulses alone would start or turn
 * sticks: so no energy is added. The others move as the coordinates do, whose velocities are what stops. */
static void close_contacts(ps_run *s, const ps_contact_numbers *c, int n, const int *contact,
                           double *x, ps_listener listener) {
  int row[PS_ROWS] = {0}, count = n;
  double impulses[PS_CONTACT_ROWS], work[2] = {0}, before[PS_NX];
  memcpy(before, x, sizeof before);
  for (int i = 0; i < n; i++) x[PS_CONTACT_STATES[contact[i]][PS_GAP]] = 0;
  book_loss(s, before, x);
  for (int i = 0; i < n; i++) row[i] = PS_N(contact[i]);
  stop_rows(c, n, row, impulses);
  for (int i = 0; i < n; i++) {
    const int t = PS_T(contact[i], 0), slip = PS_CONTACT_STATES[contact[i]][PS_SLIP];
    const double change = fabs(dot(PS_CONTACT_ROWS, c->W + t * PS_CONTACT_ROWS, impulses));
    if (c->mu[contact[i]] > 0 && fabs(x[slip]) <= change && change != 0) row[count++] = t;
  }
  if (count > n) stop_rows(c, count, row, impulses);
  for (int i = 0; i < count; i++)
    work[PS_AXIS_OF(row[i])] += impulses[row[i]] * c->velocity[row[i]] / 2;
  push_contacts(c, impulses, x);
  for (int k = 0; k < PS_RIGID; k++) {
    int closes = 0;
    for (int i = 0; i < n; i++) closes |= contact[i] == PS_RIGID_CONTACT[k];
    for (int axis = 0; axis < 2 && !closes; axis++) move_along(c, PS_ROW(PS_RIGID_CONTACT[k], axis), impulses, x);
  }
  for (int i = 0; i < 2; i++) x[PS_WORKS[i]] -= work[i];
  for (int i = 0; i < count; i++) x[rate_state(row[i])] = 0;
  tell_change(s, listener, PS_TOLD_CLOSING, n, contact, count, row, impulses, before, x);
}

/* Closes the gaps that close at the same instant but for rounding; contacts that seem to open rest. */
static void bring_together(ps_run *s, const ps_options *o, double *x) {
  ps_contact_numbers c;
  int contact[PS_RIGID], n = 0, opens = 0;
  for (int k = 0; k < PS_RIGID; k++) {
    const int i = PS_RIGID_CONTACT[k], *at = PS_CONTACT_STATES[i], gap = at[PS_GAP];
    const double rate = x[at[PS_GAP_RATE]];
    if (rate > PS_TOUCHING * state_scale(o, at[PS_GAP_RATE]) ||
        fabs(x[gap]) > PS_TOUCHING * state_scale(o, gap))
      continue;
    x[gap] = 0;
    opens |= rate > 0;
    if (rate >= 0) contact[n++] = i;
  }
  book_loss(s, s->x, x);
  if (!opens) return;
  contact_numbers_of(s, x, &c);
  close_contacts(s, &c, n, contact, x, NULL);
}

/* Closes the contacts whose bounces have died out by the time t; 0 where there is none. */
static int close_settled(ps_run *s, const ps_options *o, double t, double *x) {
  ps_contact_numbers c;
  int contact[PS_RIGID], n = 0, moves = 0;
  contact_numbers_of(s, x, &c);
  for (int k = 0; k < PS_RIGID; k++) {
    const int i = PS_RIGID_CONTACT[k], *at = PS_CONTACT_STATES[i];
    const int gap = at[PS_GAP], rate = at[PS_GAP_RATE];
    const double speed = PS_MAX(state_scale(o, rate), t * fabs(c.load[PS_N(i)]));
    if (fabs(x[gap]) < PS_SETTLED * state_scale(o, gap) && fabs(x[rate]) < PS_SETTLED * speed) {
      contact[n++] = i;
      moves |= x[rate] != 0;
    }
  }
  if (!moves) return 0;
  close_contacts(s, &c, n, contact, x, o->listener);
  return 1;
}

/* Closes the contacts that leave but would be back within `time`; 0 where there is none. */
static int close_short(ps_run *s, const ps_options *o, double time, double *x) {
  ps_contact_numbers c;
  int contact[PS_RIGID], n = 0, moves = 0;
  contact_numbers_of(s, x, &c);
  for (int k = 0; k < PS_RIGID; k++) {
    const int i = PS_RIGID_CONTACT[k], *at = PS_CONTACT_STATES[i];
    const double rate = x[at[PS_GAP_RATE]];
    const int is_short = x[at[PS_GAP]] <= 0 && rate > 0 && 2 * rate < time * -c.load[PS_N(i)];
    moves |= is_short;
    if (is_short || (x[at[PS_GAP]] <= 0 && rate == 0)) contact[n++] = i;
  }
  if (!moves) return 0;
  close_contacts(s, &c, n, contact, x, o->listener);
  return 1;
}

/* The impact of the closed contacts, from and to the state x; its impulses (2 n). 0 where it jams. */
static int impact_at(ps_run *s, const ps_options *o, double *x, double *impulses) {
  ps_contact_numbers c;
  int closed[PS_RIGID], held[PS_RIGID], row[PS_ROWS], n = 0, ended;
  double W[PS_ROWS * PS_ROWS], mu[PS_RIGID] = {0}, v[PS_ROWS], load[PS_RIGID], after[PS_ROWS];
  double P[PS_ROWS], work[PS_ROWS], e[PS_RIGID], normal = 0, tangential = 0, before[PS_NX];
  memcpy(before, x, sizeof before);
  contact_numbers_of(s, x, &c);
  for (int k = 0; k < PS_RIGID; k++) {
    const int *at = PS_CONTACT_STATES[PS_RIGID_CONTACT[k]];
    if (x[at[PS_GAP]] > 0 || x[at[PS_GAP_RATE]] > 0) continue;
    held[n] = PS_BILATERAL[k];
    e[n] = c.e[k];
    closed[n++] = PS_RIGID_CONTACT[k];
  }
  for (int i = 0; i < PS_SIZE(n); i++) row[i] = PS_ROW(closed[PS_CONTACT_OF(i)], PS_AXIS_OF(i));
  for (int i = 0; i < PS_SIZE(n); i++) {
    for (int j = 0; j < PS_SIZE(n); j++)
      W[i * PS_SIZE(n) + j] = c.W[row[i] * PS_CONTACT_ROWS + row[j]];
    v[i] = x[rate_state(row[i])];
  }
  for (int i = 0; i < n; i++) {
    mu[i] = c.mu[closed[i]];
    load[i] = c.load[PS_N(closed[i])];
  }
  ended = follow_impact(n, W, mu, v, held, load, PS_IMPACT_MEASURE, PS_IMPACT_POWER,
                        PS_IMPACT_FINAL_SLIP, e, after, P, work, o->listener);
  if (!ended) return 0;
  for (int i = 0; i < PS_CONTACT_ROWS; i++) impulses[i] = 0;
  for (int i = 0; i < n; i++) {
    normal += work[PS_N(i)];
    tangential += work[PS_T(i, 0)];
    impulses[PS_N(closed[i])] = P[PS_N(i)];
    impulses[PS_T(closed[i], 0)] = P[PS_T(i, 0)];
  }
  push_contacts(&c, impulses, x);
  /* What the impact made vanish is exactly 0. */
  for (int i = 0; i < PS_SIZE(n); i++) x[rate_state(row[i])] = after[i];
  x[PS_WORKS[0]] -= normal;
  x[PS_WORKS[1]] -= tangential;
  tell_change(s, o->listener, PS_TOLD_IMPACT, n, closed, PS_SIZE(n), row, impulses, before, x);
  return 1;
}

/* Takes over what comes after an event of the impacts. */
static void note_impact(ps_run *s, const ps_options *o, int from, int kind, const double *x,
                        const double *z) {
  s->mode = PS_IMPACT_TARGET;
  note_event(s, o, from, -1, kind, -1, x, z);
  memcpy(s->x, x, sizeof s->x);
  memcpy(s->z, z, sizeof(double) * PS_NZ);
}

/* Ends a run in the state x of the impact. */
static void stop_impact(ps_run *s, const double *x, int reason) {
  s->mode = PS_IMPACT_TARGET;
  s->reason = reason;
  s->stop_transition = -1;
  memcpy(s->x, x, sizeof s->x);
}

/* Whether a closed contact approaches. */
static int collides(const double *x) {
  int any = 0;
  for (int k = 0; k < PS_RIGID; k++) {
    const int *at = PS_CONTACT_STATES[PS_RIGID_CONTACT[k]];
    any |= x[at[PS_GAP]] <= 0 && x[at[PS_GAP_RATE]] < 0;
  }
  return any;
}

/* Answers a run that asks what follows: the limit of bounces, an impact, or a jam. 0: it ended. */
static int strike(ps_run *s, const ps_options *o) {
  const double t = s->t_base + s->t;
  const int from = (int)s->mode;
  double x[PS_NX], z[PS_NZ + 1];
  if (!(o->t_end - t > 0)) {
    s->reason = PS_T_END;
    return 0;
  }
  memcpy(x, s->x, sizeof x);
  memcpy(z, s->z, sizeof z);
  bring_together(s, o, x);
  watch_now(s);
  s->reason = PS_RUNNING;
  if (collides(s->x) && !collides(x)) { /* it was rounding of contacts that rest */
    note_impact(s, o, from, PS_SETTLE_KIND, x, z);
    begin_again(s, o);
    return 1;
  }
  if (s->last_kind == PS_TOUCHDOWN_KIND) {
    note_touchdown(s, t);
    if (touchdowns_accumulate(s)) {
      if (!close_settled(s, o, t, x)) {
        stop_impact(s, x, PS_ACCUMULATION);
        return 0;
      }
      note_impact(s, o, from, PS_SETTLE_KIND, x, z);
      begin_again(s, o);
      return 1;
    }
  }
  if (ends_before(s, o, PS_IMPACT_KIND)) {
    s->reason = PS_UNTIL;
    return 0;
  }
  if (!impact_at(s, o, x, z + PS_IMPULSES)) {
    stop_impact(s, x, PS_JAM);
    return 0;
  }
  note_impact(s, o, from, PS_IMPACT_KIND, x, z);
  if (close_short(s, o, PS_REMAINDER * t, x)) note_impact(s, o, from, PS_SETTLE_KIND, x, z);
  begin_again(s, o);
  return 1;
}
#endif
