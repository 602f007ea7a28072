/* Stiffness and exponent of the loading curve. */
static void loading_curve(const double *p, double *k, double *n) {
  double c[${NAME}_CONSTANTS], law[2], w[$work];
  const double *arg[1] = {c};
  double *res[1] = {law};
  casadi_int iw[8];
  ${name}_constants(p, c);
  loading(arg, res, iw, w, 0);
  *k = law[0];
  *n = law[1];
}

/* Scales of gap, gap rate and energy: the compression under the free normal force, that over the
 * time of a contact, and the energy at hand. */
static void scales(const double *p, const double *x, const double *found, double *gap,
                   double *rate, double *energy) {
  double W_nn = found[FOUND_W_nn], b_n = found[FOUND_b_n], k, n;
  double kinetic = found[FOUND_kinetic_energy], delta;
  double force = fabs(b_n) / W_nn, depth = -x[$gap] > 0 ? -x[$gap] : 0.0;
  loading_curve(p, &k, &n);
  double stored = k * pow(depth, n + 1) / (n + 1);
  if (force > 0)
    delta = pow(force / k, 1 / n);
  else /* nothing presses: a hundredth of what the energy at hand can compress */
    delta = 0.01 * pow((n + 1) * (kinetic + stored) / k, 1 / (n + 1));
  *energy = kinetic + stored + force * delta;
  if (*energy == 0) { /* nothing moves and nothing pushes */
    delta = characteristic_length(found);
    *energy = gained_energy(found, delta);
  }
  *rate = force > 0 ? sqrt(delta * fabs(b_n)) : 0.01 * sqrt(2 * *energy * W_nn);
  *gap = delta;
}

void ${name}_press(const double *p, double *x, double force) {
  double k, n;
  loading_curve(p, &k, &n);
  x[$gap] = -pow(force / k, 1 / n);
}

