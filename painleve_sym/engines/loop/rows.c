/* Where the rows of contacts stand in W, b, velocities and forces: those of each contact together, its
 * normal row before its tangential ones, as ContactRows in contact_rows.py. */

#define PS_TANGENTS 1
#define PS_AXES (1 + PS_TANGENTS)
/* All rows of n contacts; the row of contact i along an axis, 0 being the normal. */
#define PS_SIZE(n) (PS_AXES * (n))
#define PS_ROW(i, axis) (PS_AXES * (i) + (axis))
#define PS_N(i) PS_ROW(i, 0)
#define PS_T(i, k) PS_ROW(i, 1 + (k))
/* The contact and the axis of a row. */
#define PS_CONTACT_OF(row) ((row) / PS_AXES)
#define PS_AXIS_OF(row) ((row) % PS_AXES)
