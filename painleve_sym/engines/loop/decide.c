/* Parts whose local modes are data: where a transition decides, each part may take one of its
 * alternatives, and the first combination is taken of which no guard would fire at once. */

#if PS_NPART
static int guard_side(double g, double d, double d2, double zero, int departs);
static double first_step(ps_run *s, const ps_options *o);

/* Whether the motion can go on in the memory of the run: every guard of its mode is positive, or
 * zero and leaving upwards. */
static int consistent(ps_run *s, const ps_options *o) {
  const ps_mode *m = &PS_MODES[s->mode];
  double g[PS_NG], dg[PS_NG], d2[PS_NG], h = first_step(s, o);
  double *res[3] = {g, dg, d2};
  if (!isfinite(h)) return 0;
  call(s, m->jets, s->x, res);
  for (int j = 0; j < m->n; j++)
    if (!isfinite(g[j]) || guard_side(g[j], dg[j], d2[j], PS_ZERO_TIME * h, 0) < 0) return 0;
  return 1;
}

/* Chooses the local modes after a reset to x and z, which is changed. Returns 0 where no combination
 * is consistent. */
static int decide(ps_run *s, const ps_options *o, const double *x, double *z) {
  double condition[PS_NALT], memory[PS_NALT][PS_NZ], x_before[PS_NX], z_before[PS_NZ];
  double *res[2] = {condition, &memory[0][0]};
  int offered[PS_NPART][PS_NALT], count[PS_NPART], at[PS_NPART] = {0}, first = 0, done = 0;
  memcpy(x_before, s->x, sizeof x_before);
  memcpy(z_before, s->z, sizeof z_before);
  memcpy(s->x, x, sizeof x_before);
  memcpy(s->z, z, sizeof z_before);
  call(s, PS_ALTERNATIVES, x, res);
  int combinations = 1;
  for (int p = 0; p < PS_NPART; p++) {
    count[p] = 0;
    for (int a = first; a < first + PS_OFFERED[p]; a++)
      if (condition[a] > 0) offered[p][count[p]++] = a;
    first += PS_OFFERED[p];
    combinations *= count[p];
  }
  for (int k = 0; k < combinations && !done; k++) {
    for (int p = 0; p < PS_NPART; p++)
      for (int i = PS_OWNED[p]; i < PS_OWNED[p + 1]; i++) s->z[i] = memory[offered[p][at[p]]][i];
    done = combinations == 1 || consistent(s, o);
    for (int p = PS_NPART - 1; !done && p >= 0 && ++at[p] == count[p]; p--) at[p] = 0;
  }
  if (done) memcpy(z, s->z, sizeof z_before);
  memcpy(s->x, x_before, sizeof x_before);
  memcpy(s->z, z_before, sizeof z_before);
  return done;
}
#endif
