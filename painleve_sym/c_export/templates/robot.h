/* Risk of the contact $contact of the robot $robot, written by painleve-sym $version.
 *
 * $subject
 *
 * Assumptions: ideal torque control, rigid links, one point of contact. */
#ifndef ${guard}_H
#define ${guard}_H

#ifdef __cplusplus
extern "C" {
#endif

enum { ${guard}_JOINTS = $count };

/* Names of the joints in the order of their values; rad or m. */
extern const char *const ${name}_joint_names[$room];

typedef struct {
  double W[3][3];    /* mobility with the rows n, t1, t2; 1/kg */
  double mu_P;       /* friction from which A < 0 for some slip; infinite where none does it */
  double direction;  /* angle of the worst slip from t1 towards t2; rad; 0 where none is */
  double tangent[3]; /* t1 in the axes of the base; t2 = n x t1 */
} ${name}_risk;

/* Compute the risk at joint values, for a unit normal in the axes of the base.
 *
 * t1 is the axis x of the base along the surface, y where the normal is nearly x. */
void ${name}_compute(const double *joints, const double normal[3], ${name}_risk *risk);

/* Half the angle of the sector of slip with A < 0 about the direction, for a friction mu; rad. */
double ${name}_half_angle(const ${name}_risk *risk, double mu);

#ifdef __cplusplus
}
#endif

#endif
