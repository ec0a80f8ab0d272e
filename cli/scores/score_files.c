#include "scores/score_files.h"

#include <string.h>

#include "makers/kept_list.h"
#include "pictures/planes.h"
#include "scores/box_score.h"
#include "scores/flow_score.h"
#include "scores/label_score.h"
#include "scores/picture_score.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"

static void begin(const job *at)
{
    if (at->json) {
        json_begin();
    }
}

static int score_labels(job *at, const score_options *options)
{
    const char *const *operands = at->given->operands;
    label_map map, truth;
    label_score score;
    (void)options;
    TRY(label_map_read(operands[0], &at->limit, &map));
    TRY(label_map_read(operands[1], &at->limit, &truth));
    TRY(label_map_check(&map, &truth));
    TRY(label_score_find(&map, &truth, &at->limit, &score));
    begin(at);
    (at->json ? label_score_json : label_score_print)(&score);
    return DONE;
}

static int score_pictures(job *at, const score_options *options)
{
    const char *const *operands = at->given->operands;
    const char *hole = options->hole;
    qs_image map, truth, mask = {0};
    picture_score score;
    TRY(grey_read(operands[0], &at->limit, &map));
    TRY(grey_read(operands[1], &at->limit, &truth));
    TRY(same_size_check(operands[0], map.width, map.height, operands[1], truth.width,
                        truth.height));
    if (hole != NULL) {
        TRY(grey_read(hole, &at->limit, &mask));
        TRY(same_size_check(hole, mask.width, mask.height, operands[1], truth.width, truth.height));
    }
    picture_score_find(&map, &truth, mask.pixels, &score);
    begin(at);
    (at->json ? picture_score_json : picture_score_print)(&score);
    return DONE;
}

static int score_flow(job *at, const score_options *options)
{
    const char *const *operands = at->given->operands;
    flow_field field, truth;
    flow_score score;
    (void)options;
    TRY(flow_read(operands[0], &at->limit, &field));
    TRY(flow_read(operands[1], &at->limit, &truth));
    TRY(same_size_check(operands[0], field.width, field.height, operands[1], truth.width,
                        truth.height));
    flow_score_find(&field, &truth, &score);
    begin(at);
    (at->json ? flow_score_json : flow_score_print)(&score);
    return score.pixels > 0
               ? DONE
               : fail(ANSWER_NO, input_name(operands[0]), "no pixel is known both here and in %s",
                      input_name(operands[1]));
}

/* What is scored: the boxes of OUT, or those of --boxes that OUT keeps. */
static int read_boxes(job *at, const char *path, const char *of, box_file *read)
{
    box_file all;
    uint16_t *kept = NULL;
    if (of == NULL) {
        return boxes_read(path, true, &at->limit, read);
    }
    TRY(boxes_read(of, true, &at->limit, &all));
    TRY(kept_list_read(path, &all, &at->limit, &kept));
    return kept_boxes_take(&all, kept, &at->limit, read);
}

static int score_boxes(job *at, const score_options *options)
{
    const char *const *operands = at->given->operands;
    box_file boxes, truth;
    box_score score;
    TRY(read_boxes(at, operands[0], options->boxes, &boxes));
    TRY(boxes_read(operands[1], false, &at->limit, &truth));
    TRY(box_score_find(&boxes, &truth, &at->limit, &score));
    begin(at);
    (at->json ? box_score_json : box_score_print)(&score);
    return DONE;
}

static const struct {
    const char *name;
    int (*score)(job *at, const score_options *options);
} kinds[] = {{"disparity", NULL},
             {"labels", score_labels},
             {"picture", score_pictures},
             {"flow", score_flow},
             {"boxes", score_boxes}};
enum { KINDS = sizeof kinds / sizeof kinds[0], PICTURE_KIND = 2, BOXES_KIND = 4 };

int score_files(job *at, const char *as, const score_options *options)
{
    named names[KINDS];
    int kind = 0;
    for (int i = 0; i < KINDS; i++) {
        names[i] = (named){kinds[i].name, i};
    }
    const name_table table = {"as", names, KINDS, KINDS};
    TRY(name_read(&table, as, "", &kind));
    if (options->hole != NULL && kind != PICTURE_KIND) {
        return fail_usage("--hole goes with --as picture: leave it out");
    }
    if (options->boxes != NULL && kind != BOXES_KIND) {
        return fail_usage("--boxes goes with --as boxes: leave it out");
    }
    int status = kinds[kind].score(at, options);
    if (at->json && (status == DONE || status == ANSWER_NO)) {
        json_end();
    }
    return status;
}
