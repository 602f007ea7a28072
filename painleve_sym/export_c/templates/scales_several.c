/* Stiffness and exponent of the loading curve of each contact, 0 where it is rigid. */
static void loading_curves(const double *p, double *curves) {
  double c[${NAME}_CONSTANTS], w[$work];
  const double *arg[1] = {c};
  double *res[1] = {curves};
  casadi_int iw[8];
  ${name}_constants(p, c);
  loading(arg, res, iw, w, 0);
}

/* Scales of gap and gap rate of one contact, and its energy: of a compliant one the compression under
 * the free normal force, that over the time of a contact, and the energy at hand. */
static void own_scales(const double *curve, double kinetic, double W_nn, double b_n, double x_gap,
                       double *gap, double *rate, double *energy) {
  const double k = curve[0], n = curve[1];
  double force = b_n / W_nn, depth = -x_gap > 0 ? -x_gap : 0.0, delta, stored;
  if (n == 0) {
    *energy = kinetic > 1e-20 ? kinetic : 1.0; /* below: a motion from rest */
    *gap = 1.0;
    *rate = sqrt(2 * *energy * W_nn);
    return;
  }
  stored = k * pow(depth, n + 1) / (n + 1);
  if (force > 0)
    delta = pow(force / k, 1 / n);
  else /* nothing presses: a hundredth of what the energy at hand can compress */
    delta = 0.01 * pow((n + 1) * (kinetic + stored) / k, 1 / (n + 1));
  *energy = kinetic + stored + force * delta;
  if (*energy == 0) delta = *energy = 1.0; /* nothing moves and nothing pushes */
  *rate = force > 0 ? sqrt(delta * b_n) : 0.01 * sqrt(2 * *energy * W_nn);
  *gap = delta;
}

/* Scales of gap and gap rate of each contact, all with the largest energy of any. A contact that
 * hardly anything presses yet is hit by what presses the others: its free acceleration counts as a
 * hundredth of theirs at least. */
static void scales(const double *p, const double *x, const double *found, double *gap,
                   double *rate, double *energy) {
  double curves[2 * CONTACTS], b[CONTACTS], least = 0, own, largest = 0;
  loading_curves(p, curves);
  for (int i = 0; i < CONTACTS; i++) least = fmax(least, fabs(found[i * FOUND + FOUND_b_n]));
  least = 0.01 * least;
  for (int i = 0; i < CONTACTS; i++) {
    const double *f = found + i * FOUND, kinetic = f[FOUND_kinetic_energy];
    const double x_gap = x[CONTACT_STATES[i][0]];
    b[i] = fmax(fabs(f[FOUND_b_n]), least);
    own_scales(curves + 2 * i, kinetic, f[FOUND_W_nn], b[i], x_gap, &gap[i], &rate[i], &own);
    if (kinetic > 0 || b[i] != 0 || x_gap < 0) largest = fmax(largest, own);
  }
  *energy = largest > 0 ? largest : 1.0;
  for (int i = 0; i < CONTACTS; i++)
    own_scales(curves + 2 * i, *energy, found[i * FOUND + FOUND_W_nn], b[i],
               x[CONTACT_STATES[i][0]], &gap[i], &rate[i], &own);
}
