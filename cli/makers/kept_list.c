#include "makers/kept_list.h"

#include <inttypes.h>
#include <string.h>

#include "text/fail.h"
#include "text/numbers.h"

void kept_list_write(const uint16_t *kept, uint32_t count, output *out)
{
    fprintf(out->file, "%s\n", kept_list_head);
    for (uint32_t i = 0; i < count; i++) {
        fprintf(out->file, "%" PRIu32 ",%d\n", i + 1, kept[i] == 1);
    }
}

/* The next line without its end; NULL after the last. */
static char *next_line(char **rest)
{
    char *line = *rest, *end = strchr(line, '\n');
    if (*line == '\0') {
        return NULL;
    }
    *rest = end != NULL ? end + 1 : line + strlen(line);
    line[strcspn(line, "\r\n")] = '\0';
    return line;
}

static int read_lines(const char *name, char *text, const box_file *of, uint16_t *kept)
{
    const char *line = next_line(&text);
    uint32_t count = 0, pair[2];
    if (line == NULL || strcmp(line, kept_list_head) != 0) {
        return fail(BAD_INPUT, name,
                    "does not begin with the line %s: without --boxes it is scored as a file of "
                    "boxes",
                    kept_list_head);
    }
    for (; (line = next_line(&text)) != NULL; count++) {
        if (!numbers_read(line, ',', pair, 2) || pair[0] != count + 1 || pair[1] > 1) {
            return fail(BAD_INPUT, name,
                        "line %" PRIu32 ": %s is not box %" PRIu32 " and 0 or 1, as %" PRIu32 ",1",
                        count + 2, line, count + 1, count + 1);
        }
        if (count < of->count) {
            kept[count] = (uint16_t)pair[1];
        }
    }
    return count == of->count ? DONE
                              : fail(BAD_INPUT, name,
                                     "is a list of %" PRIu32 " box%s, but %s has %" PRIu32
                                     ": give the file that the problem was made of",
                                     count, count == 1 ? "" : "es", of->name, of->count);
}

int kept_list_read(const char *path, const box_file *of, budget *limit, uint16_t **kept)
{
    file_bytes file;
    TRY(file_read(path, limit, &file));
    char *text = budget_take(limit, path, file.size + 1);
    *kept = budget_take(limit, path, of->count * sizeof **kept);
    if (text == NULL || *kept == NULL) {
        return NO_RESOURCE;
    }
    memcpy(text, file.bytes, file.size);
    text[file.size] = '\0';
    return read_lines(input_name(path), text, of, *kept);
}

int kept_boxes_check(const char *problem, uint32_t sites, const box_file *boxes)
{
    return boxes->count == sites
               ? DONE
               : fail(BAD_INPUT, boxes->name,
                      "has %" PRIu32 " box%s, but %s was made of %" PRIu32
                      ": give the file that it was made of",
                      boxes->count, boxes->count == 1 ? "" : "es", problem, sites);
}

int kept_boxes_take(const box_file *all, const uint16_t *kept, budget *limit, box_file *taken)
{
    *taken = *all;
    taken->count = 0;
    taken->boxes = budget_take(limit, all->name, all->count * sizeof *taken->boxes);
    taken->pictures = budget_take(limit, all->name, all->count * sizeof *taken->pictures);
    if (taken->boxes == NULL || taken->pictures == NULL) {
        return NO_RESOURCE;
    }
    for (uint32_t i = 0; i < all->count; i++) {
        if (kept[i] == 1) {
            taken->boxes[taken->count] = all->boxes[i];
            taken->pictures[taken->count++] = all->pictures[i];
        }
    }
    return DONE;
}
