#include "camera/rectification.h"

#include <math.h>
#include <string.h>

#include "camera/lens.h"
#include "text/fail.h"

/* The rotation about an axis by an angle: Rodrigues' formula. The axis has length 1, or the angle
 * is 0. */
static void rotation_about(const double axis[3], double angle, double r[9])
{
    double c = cos(angle), s = sin(angle), x = axis[0], y = axis[1], z = axis[2];
    const double made[9] = {
        c + x * x * (1 - c),     x * y * (1 - c) - z * s, x * z * (1 - c) + y * s,
        x * y * (1 - c) + z * s, c + y * y * (1 - c),     y * z * (1 - c) - x * s,
        x * z * (1 - c) - y * s, y * z * (1 - c) + x * s, c + z * z * (1 - c)};
    memcpy(r, made, sizeof made);
}

static double length_of(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Turns the other way, by half of the angle. Returns false if the angle is a right angle or
 * more. */
static bool half_back(const double r[9], double half[9])
{
    double axis[3] = {r[7] - r[5], r[2] - r[6], r[3] - r[1]};
    double sine = length_of(axis) / 2, cosine = (r[0] + r[4] + r[8] - 1) / 2;
    for (int i = 0; i < 3; i++) {
        axis[i] = sine > 0 ? axis[i] / (2 * sine) : 0;
    }
    rotation_about(axis, -atan2(sine, cosine) / 2, half);
    return cosine > 0;
}

static void turn(const double r[9], const double v[3], double turned[3])
{
    for (int i = 0; i < 3; i++) {
        turned[i] = r[3 * i] * v[0] + r[3 * i + 1] * v[1] + r[3 * i + 2] * v[2];
    }
}

/* The rotations of both cameras; their baseline then lies along the rows. `shift` is what the right
 * camera's points are shifted by. */
static int find_rotations(calibration *of, double *shift)
{
    double half[9], back[9], level[9], t[3], axis[3];
    if (!half_back(of->rotation, half)) {
        return fail(BAD_INPUT, of->name,
                    "R turns by a right angle or more: the cameras do not look the same way");
    }
    turn(half, of->translation, t);
    double length = length_of(t);
    if (!(length > 0) || fabs(t[0]) <= fabs(t[1]) || t[0] > 0) {
        return fail(BAD_INPUT, of->name,
                    "T does not lead from the left camera to one on its right: %s",
                    t[0] > 0 ? "calibrate with the left camera as the first one"
                             : "qstereo matches cameras side by side");
    }
    /* The cross product of t and (-1, 0, 0), the direction that t is to have. */
    const double cross[3] = {0, -t[2], t[1]};
    double sine = length_of(cross);
    for (int i = 0; i < 3; i++) {
        axis[i] = sine > 0 ? cross[i] / sine : 0;
    }
    rotation_about(axis, atan2(sine, -t[0]), level);
    matrix_transpose(half, back);
    matrix_product(level, back, of->cameras[0].rotation);
    matrix_product(level, half, of->cameras[1].rotation);
    turn(of->cameras[1].rotation, of->translation, t);
    *shift = t[0];
    return DONE;
}

/* Where a pixel of a camera's picture lies once it is rectified, with focal length 1. */
static point rectified(const camera *of, double x, double y)
{
    return ray_turned(of->rotation, lens_ray(of, (point){x, y}));
}

/* The mean of where the corners of a picture lie. */
static point mean_corner(const calibration *of, unsigned side)
{
    double right = of->width - 1, bottom = of->height - 1;
    point sum = {0, 0};
    for (int corner = 0; corner < 4; corner++) {
        point at =
            rectified(&of->cameras[side], corner % 2 == 0 ? 0 : right, corner < 2 ? 0 : bottom);
        sum = (point){sum.x + at.x / 4, sum.y + at.y / 4};
    }
    return sum;
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* The enlargement that takes an edge of a camera's picture, `seen` from the principal point with
 * focal length 1, to the `wanted` edge of the rectified picture. Infinite where it is seen on the
 * wrong side. */
static double to_edge(double wanted, double seen, double focal)
{
    return seen > 0 ? wanted / (focal * seen) : HUGE_VAL;
}

/* The least enlargement at which the edges of a camera's picture, looked at in points of a grid,
 * leave the rectified picture. */
static double find_enlargement(const calibration *of, unsigned side, double focal, point centre)
{
    enum { STEPS = 8 };
    const camera *seen = &of->cameras[side];
    double right = of->width - 1, bottom = of->height - 1, least = 0;
    for (int step = 0; step <= STEPS; step++) {
        double x = right * step / STEPS, y = bottom * step / STEPS;
        least = larger(least, to_edge(centre.x, -rectified(seen, 0, y).x, focal));
        least = larger(least, to_edge(right - centre.x, rectified(seen, right, y).x, focal));
        least = larger(least, to_edge(centre.y, -rectified(seen, x, 0).y, focal));
        least = larger(least, to_edge(bottom - centre.y, rectified(seen, x, bottom).y, focal));
    }
    return least;
}

static void set_projection(double p[12], double focal, point centre, double shift)
{
    const double made[12] = {focal, 0, centre.x, focal * shift, 0, focal, centre.y, 0, 0, 0, 1, 0};
    memcpy(p, made, sizeof made);
}

int rectification_find(calibration *of)
{
    double shift;
    TRY(find_rotations(of, &shift));
    double focal = (of->cameras[0].matrix[4] + of->cameras[1].matrix[4]) / 2;
    point left = mean_corner(of, 0), right = mean_corner(of, 1);
    const point centre = {(of->width - 1) / 2.0 - focal * (left.x + right.x) / 2,
                          (of->height - 1) / 2.0 - focal * (left.y + right.y) / 2};
    focal *= larger(find_enlargement(of, 0, focal, centre), find_enlargement(of, 1, focal, centre));
    if (!isfinite(focal) || !(focal > 0)) {
        return fail(BAD_INPUT, of->name,
                    "its cameras see nothing in common, or a lens bends the edges of its picture "
                    "back: give R1, R2, P1 and P2, too");
    }
    set_projection(of->cameras[0].projection, focal, centre, 0);
    set_projection(of->cameras[1].projection, focal, centre, shift);
    return DONE;
}
