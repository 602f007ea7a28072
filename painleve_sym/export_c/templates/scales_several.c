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
static void own_scales(const double *curve, const double *found, double x_gap, double *gap,
                       double *rate, double *energy) {
  const double k = curve[0], n = curve[1], kinetic = found[FOUND_kinetic_energy];
  const double W_nn = found[FOUND_W_nn], b_n = fabs(found[FOUND_b_n]), force = b_n / W_nn;
  double depth = -x_gap > 0 ? -x_gap : 0.0, length = characteristic_length(found), delta, stored;
  double gained = gained_energy(found, length);
  if (n == 0) {
    *gap = length;
    *energy = kinetic > $at_rest * gained ? kinetic : gained; /* below: a motion from rest */
    *rate = sqrt(2 * *energy * W_nn);
    return;
  }
  stored = k * pow(depth, n + 1) / (n + 1);
  if (force > 0)
    delta = pow(force / k, 1 / n);
  else /* nothing presses: a hundredth of what the energy at hand can compress */
    delta = 0.01 * pow((n + 1) * (kinetic + stored) / k, 1 / (n + 1));
  *energy = kinetic + stored + force * delta;
  if (*energy == 0) { /* nothing moves and nothing pushes */
    delta = length;
    *energy = gained;
  }
  *rate = force > 0 ? sqrt(delta * b_n) : 0.01 * sqrt(2 * *energy * W_nn);
  *gap = delta;
}

/* Scales of gap and gap rate of each contact, all with the largest energy of any. A contact that
 * hardly anything presses yet is hit by what presses the others: its free acceleration counts as a
 * hundredth of theirs at least. */
static void scales(const double *p, const double *x, const double *found, double *gap,
                   double *rate, double *energy) {
  double curves[2 * CONTACTS], pressed[CONTACTS * FOUND], least = 0, own, largest = 0;
  memcpy(pressed, found, sizeof pressed);
  loading_curves(p, curves);
  for (int i = 0; i < CONTACTS; i++) least = fmax(least, fabs(found[i * FOUND + FOUND_b_n]));
  least = 0.01 * least;
  for (int i = 0; i < CONTACTS; i++) {
    double *f = pressed + i * FOUND, x_gap = x[CONTACT_STATES[i][0]];
    f[FOUND_b_n] = fmax(fabs(f[FOUND_b_n]), least);
    own_scales(curves + 2 * i, f, x_gap, &gap[i], &rate[i], &own);
    if (f[FOUND_kinetic_energy] > 0 || f[FOUND_b_n] != 0 || x_gap < 0) largest = fmax(largest, own);
  }
  *energy = largest > 0 ? largest : 1.0;
  for (int i = 0; i < CONTACTS; i++) {
    pressed[i * FOUND + FOUND_kinetic_energy] = *energy;
    own_scales(curves + 2 * i, pressed + i * FOUND, x[CONTACT_STATES[i][0]], &gap[i], &rate[i],
               &own);
  }
}
