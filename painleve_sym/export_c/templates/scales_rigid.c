/* Scales of gap, gap rate and energy. */
static void scales(const double *p, const double *x, const double *found, double *gap,
                   double *rate, double *energy) {
  double kinetic = found[FOUND_kinetic_energy], gained;
  (void)p;
  (void)x;
  *gap = characteristic_length(found);
  gained = gained_energy(found, *gap);
  *energy = kinetic > $at_rest * gained ? kinetic : gained; /* below: a motion from rest */
  *rate = sqrt(2 * *energy * found[FOUND_W_nn]);
}
