#include "camera/lens.h"

void matrix_product(const double a[9], const double b[9], double product[9])
{
    for (int i = 0; i < 9; i++) {
        const double *row = &a[i / 3 * 3];
        product[i] = row[0] * b[i % 3] + row[1] * b[3 + i % 3] + row[2] * b[6 + i % 3];
    }
}

void matrix_transpose(const double a[9], double transposed[9])
{
    for (int i = 0; i < 9; i++) {
        transposed[i] = a[i % 3 * 3 + i / 3];
    }
}

/* The factor of the radius, and what is added after it. */
static double distort(const double d[DISTORTIONS], point ray, point *added)
{
    double x = ray.x, y = ray.y, r2 = x * x + y * y;
    added->x = 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x) + (d[8] + d[9] * r2) * r2;
    added->y = d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y + (d[10] + d[11] * r2) * r2;
    return (1 + ((d[4] * r2 + d[1]) * r2 + d[0]) * r2) /
           (1 + ((d[7] * r2 + d[6]) * r2 + d[5]) * r2);
}

point lens_pixel(const camera *of, point ray)
{
    const double *k = of->matrix;
    point added;
    double factor = distort(of->distortion, ray, &added);
    const point bent = {ray.x * factor + added.x, ray.y * factor + added.y};
    return (point){k[0] * bent.x + k[2], k[4] * bent.y + k[5]};
}

point lens_ray(const camera *of, point pixel)
{
    enum { STEPS = 5 };
    const double *k = of->matrix;
    const point bent = {(pixel.x - k[2]) / k[0], (pixel.y - k[5]) / k[4]};
    point ray = bent;
    for (int step = 0; step < STEPS; step++) {
        point added;
        double factor = distort(of->distortion, ray, &added);
        ray = (point){(bent.x - added.x) / factor, (bent.y - added.y) / factor};
    }
    return ray;
}

point ray_turned(const double r[9], point ray)
{
    double z = r[6] * ray.x + r[7] * ray.y + r[8];
    return (point){(r[0] * ray.x + r[1] * ray.y + r[2]) / z,
                   (r[3] * ray.x + r[4] * ray.y + r[5]) / z};
}
