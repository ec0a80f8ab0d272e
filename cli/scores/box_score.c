#include "scores/box_score.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/fail.h"
#include "text/json.h"

static const double overlap_least = 0.5;

/* A box and its place in the file, for sorting. */
typedef struct ranked {
    int32_t score;
    uint32_t at;
} ranked;

/* By falling score; of equals the first one of the file comes first. */
static int compare(const void *a, const void *b)
{
    const ranked *p = a, *q = b;
    if (p->score != q->score) {
        return p->score > q->score ? -1 : 1;
    }
    return p->at < q->at ? -1 : p->at > q->at;
}

static bool same_picture(slice a, slice b)
{
    return a.size == b.size && memcmp(a.text, b.text, a.size) == 0;
}

/* Returns true if the box takes a true one. */
static bool takes(const box_file *boxes, uint32_t at, const box_file *truth, bool *taken)
{
    uint32_t most = 0;
    double best = 0;
    for (uint32_t t = 0; t < truth->count; t++) {
        if (same_picture(boxes->pictures[at], truth->pictures[t])) {
            double overlap = boxes_overlap(&boxes->boxes[at], &truth->boxes[t]);
            most = overlap > best ? t : most;
            best = overlap > best ? overlap : best;
        }
    }
    if (best < overlap_least || taken[most]) {
        return false;
    }
    taken[most] = true;
    return true;
}

/* Adds up the curve from its end, where the precision that counts is the largest seen. */
static double area(const bool *right, uint32_t count, uint32_t rights, uint32_t truths)
{
    double sum = 0, largest = 0;
    for (uint32_t i = count; i > 0; i--) {
        double precision = (double)rights / i;
        largest = precision > largest ? precision : largest;
        if (right[i - 1]) {
            sum += largest;
            rights--;
        }
    }
    return truths > 0 ? sum / truths : 0;
}

int box_score_find(const box_file *boxes, const box_file *truth, budget *limit, box_score *found)
{
    ranked *order = budget_take(limit, boxes->name, boxes->count * sizeof *order);
    bool *right = budget_take(limit, boxes->name, boxes->count * sizeof *right);
    bool *taken = budget_take(limit, truth->name, truth->count * sizeof *taken);
    if (order == NULL || right == NULL || taken == NULL) {
        return NO_RESOURCE;
    }
    for (uint32_t i = 0; i < boxes->count; i++) {
        order[i] = (ranked){boxes->boxes[i].score, i};
    }
    qsort(order, boxes->count, sizeof *order, compare);
    memset(taken, 0, truth->count * sizeof *taken);
    *found = (box_score){.boxes = boxes->count, .truths = truth->count};
    for (uint32_t i = 0; i < boxes->count; i++) {
        right[i] = takes(boxes, order[i].at, truth, taken);
        found->right += right[i];
    }
    found->precision = boxes->count > 0 ? (double)found->right / boxes->count : 0;
    found->recall = truth->count > 0 ? (double)found->right / truth->count : 0;
    found->ap = area(right, boxes->count, found->right, truth->count);
    return DONE;
}

void box_score_json(const box_score *shown)
{
    json_count("boxes", shown->boxes);
    json_count("truths", shown->truths);
    json_count("right", shown->right);
    json_real("precision", shown->precision);
    json_real("recall", shown->recall);
    json_real("ap", shown->ap);
}

void box_score_print(const box_score *shown)
{
    printf("precision %.4f, recall %.4f, ap %.4f: %" PRIu32 " of %" PRIu32
           " boxes are right, of %" PRIu32 " true ones\n",
           shown->precision, shown->recall, shown->ap, shown->right, shown->boxes, shown->truths);
}
