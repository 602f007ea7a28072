#include "$name.h"

$generated

const char *const ${name}_joint_names[$room] = {$names};

void ${name}_compute(const double *joints, const double normal[3], ${name}_risk *risk) {
  double in[${guard}_JOINTS + 6], work[$work], *t = risk->tangent, along, length;
  casadi_int integers[$integers];
  const double *arg[$arguments] = {in};
  double *res[$results] = {&risk->W[0][0]};
  int k, first = fabs(normal[0]) > 0.9 ? 1 : 0;
  for (k = 0; k < 3; ++k) t[k] = k == first ? 1.0 : 0.0;
  along = normal[first];
  for (k = 0; k < 3; ++k) t[k] -= along * normal[k];
  length = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
  for (k = 0; k < 3; ++k) t[k] /= length;
  for (k = 0; k < ${guard}_JOINTS; ++k) in[k] = joints[k];
  for (k = 0; k < 3; ++k) {
    in[${guard}_JOINTS + k] = normal[k];
    in[${guard}_JOINTS + 3 + k] = t[k];
  }
  mobility(arg, res, integers, work, 0);
  risk->mu_P = risk->W[0][0] / hypot(risk->W[1][0], risk->W[2][0]);
  risk->direction = atan2(risk->W[2][0], risk->W[1][0]);
  if (!(risk->mu_P < $infinite)) {
    /* Only rounding couples normal and slip. */
    risk->mu_P = INFINITY;
    risk->direction = 0.0;
  }
}

double ${name}_half_angle(const ${name}_risk *risk, double mu) {
  return mu > risk->mu_P ? acos(risk->mu_P / mu) : 0.0;
}
