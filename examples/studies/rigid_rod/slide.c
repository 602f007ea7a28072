/* Motion of a bar's modes on a contact K d^n at a frozen angle, by Runge-Kutta's method of order 4.

   Per mode: `rates` (rad/s), `normal` and `along` (how the end moves up and to the right), `push`
   (how its force acts, per mass). `contact` is K, n, e. `ends` receives stop, separation, peak. */
#include <math.h>
#include <string.h>

#define MOST 256

static double force(const double *contact, double d, double deepest) {
  double K = contact[0], n = contact[1], e2 = contact[2] * contact[2];
  if (e2 == 1 || d >= deepest) return d > 0 ? K * pow(d, n) : 0;
  double back = (d - deepest * (1 - e2)) / e2;
  return back > 0 ? K * pow(back, n) : 0;
}

int slide(int modes, const double *rates, const double *normal, const double *along,
          const double *push, double damping, const double *contact, double gravity,
          double approach, double speed, double step, double window, int bounces, double *ends) {
  double q[MOST] = {0}, p[MOST] = {0}, at[MOST], a[MOST], sum_q[MOST], sum_p[MOST], v[MOST];
  static const double part[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
  double deepest = 0, before = 0, slip = -speed;
  int touched = 0;
  if (modes > MOST) return 1;
  ends[0] = ends[1] = NAN, ends[2] = 0;
  for (double t = 0; t < window; t += step) {
    memset(sum_q, 0, sizeof sum_q), memset(sum_p, 0, sizeof sum_p);
    for (int stage = 0; stage < 4; stage++) {
      double h = part[stage] * step, time = t + h, d = approach * time + gravity * time * time / 2;
      for (int i = 0; i < modes; i++) {
        at[i] = q[i] + (stage ? h * v[i] : 0);
        d -= at[i] * normal[i];
      }
      double F = force(contact, d, deepest);
      for (int i = 0; i < modes; i++) {
        double rate = p[i] + (stage ? h * a[i] : 0);
        a[i] = push[i] * F - rates[i] * (rates[i] * at[i] + 2 * damping * rate);
        v[i] = rate;
        sum_q[i] += weight[stage] * v[i], sum_p[i] += weight[stage] * a[i];
      }
    }
    double now = t + step, d = approach * now + gravity * now * now / 2, next = -speed;
    for (int i = 0; i < modes; i++) {
      q[i] += step / 6 * sum_q[i], p[i] += step / 6 * sum_p[i];
      d -= q[i] * normal[i], next += p[i] * along[i];
    }
    deepest = d > 0 ? fmax(deepest, d) : 0;
    double F = force(contact, d, deepest), late = next / (next - slip);
    int stops = F > 0 && next >= 0;
    ends[2] = fmax(ends[2], stops ? F - late * (F - before) : F);
    if (stops) {
      ends[0] = now - step * late;
      return 0;
    }
    if (touched && F == 0 && isnan(ends[1])) {
      ends[1] = now;
      if (!bounces) return 0;
    }
    touched |= F > 0, slip = next, before = F;
  }
  return 0;
}
