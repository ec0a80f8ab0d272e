#include "scores/picture_score.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "text/json.h"

enum { SIDE = 11, WHITE = 255 };

/* The weights of the window, whose sum is 1. */
static void fill_window(double window[SIDE][SIDE])
{
    double sum = 0;
    for (int y = 0; y < SIDE; y++) {
        for (int x = 0; x < SIDE; x++) {
            int i = x - SIDE / 2, j = y - SIDE / 2;
            window[y][x] = exp(-(i * i + j * j) / (2 * 1.5 * 1.5));
            sum += window[y][x];
        }
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        window[i / SIDE][i % SIDE] /= sum;
    }
}

/* The similarity of two windows: eq. (13) of the paper. */
static double similarity(double window[SIDE][SIDE], const uint8_t *a, size_t a_stride,
                         const uint8_t *b, size_t b_stride)
{
    const double c1 = (0.01 * WHITE) * (0.01 * WHITE), c2 = (0.03 * WHITE) * (0.03 * WHITE);
    double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
    for (size_t y = 0; y < SIDE; y++) {
        for (size_t x = 0; x < SIDE; x++) {
            double w = window[y][x], p = a[y * a_stride + x], q = b[y * b_stride + x];
            mean_a += w * p;
            mean_b += w * q;
            aa += w * p * p;
            bb += w * q * q;
            ab += w * p * q;
        }
    }
    double spread = aa - mean_a * mean_a + bb - mean_b * mean_b;
    return (2 * mean_a * mean_b + c1) * (2 * (ab - mean_a * mean_b) + c2) /
           ((mean_a * mean_a + mean_b * mean_b + c1) * (spread + c2));
}

static double ssim_of(const qs_image *map, const qs_image *truth)
{
    double window[SIDE][SIDE], sum = 0;
    size_t columns = map->width - SIDE + 1, rows = map->height - SIDE + 1;
    fill_window(window);
    for (size_t y = 0; y < rows; y++) {
        for (size_t x = 0; x < columns; x++) {
            sum += similarity(window, map->pixels + y * map->stride + x, map->stride,
                              truth->pixels + y * truth->stride + x, truth->stride);
        }
    }
    return sum / (double)(columns * rows);
}

static double psnr_of(double squares, uint64_t pixels)
{
    return 10 * log10((double)WHITE * WHITE * (double)pixels / squares);
}

void picture_score_find(const qs_image *map, const qs_image *truth, const uint8_t *hole,
                        picture_score *found)
{
    double all = 0, inside = 0;
    memset(found, 0, sizeof *found);
    found->pixels = (uint64_t)map->width * map->height;
    for (size_t y = 0; y < map->height; y++) {
        for (size_t x = 0; x < map->width; x++) {
            double off =
                map->pixels[y * map->stride + x] - (double)truth->pixels[y * truth->stride + x];
            all += off * off;
            if (hole != NULL && hole[y * map->width + x] != 0) {
                inside += off * off;
                found->hole_pixels++;
            }
        }
    }
    found->mse = all / (double)found->pixels;
    found->psnr = psnr_of(all, found->pixels);
    found->hole_psnr = found->hole_pixels > 0 ? psnr_of(inside, found->hole_pixels) : 0;
    found->has_ssim = map->width >= SIDE && map->height >= SIDE;
    found->ssim = found->has_ssim ? ssim_of(map, truth) : 0;
}

/* A key of JSON with a number, or null if it is infinite. */
static void json_finite(const char *key, double number)
{
    if (isfinite(number)) {
        json_real(key, number);
    } else {
        json_null(key);
    }
}

void picture_score_json(const picture_score *shown)
{
    json_count("pixels", shown->pixels);
    json_real("mse", shown->mse);
    json_finite("psnr", shown->psnr);
    json_finite("ssim", shown->has_ssim ? shown->ssim : NAN);
    if (shown->hole_pixels > 0) {
        json_count("hole_pixels", shown->hole_pixels);
        json_finite("hole_psnr", shown->hole_psnr);
    }
}

void picture_score_print(const picture_score *shown)
{
    printf("psnr %.2f dB", shown->psnr);
    if (shown->has_ssim) {
        printf(", ssim %.4f", shown->ssim);
    }
    if (shown->hole_pixels > 0) {
        printf(", psnr in the hole %.2f dB", shown->hole_psnr);
    }
    putchar('\n');
}
