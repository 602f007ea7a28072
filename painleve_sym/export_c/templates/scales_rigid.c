/* Scales of gap, gap rate and energy. */
static void scales(const double *p, const double *x, const double *found, double *gap,
                   double *rate, double *energy) {
  double kinetic = found[FOUND_kinetic_energy];
  (void)p;
  (void)x;
  *energy = kinetic > 1e-20 ? kinetic : 1.0; /* below: a motion from rest */
  *gap = 1.0;
  *rate = sqrt(2 * *energy * found[FOUND_W_nn]);
}
