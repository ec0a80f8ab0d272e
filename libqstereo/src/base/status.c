#include "../../include/qstereo/status.h"

static const char *const texts[] = {
    [QS_OK] = "done",
    [QS_E_ARGUMENT] = "an argument is out of its range",
    [QS_E_WORKSPACE] = "the workspace is too small",
    [QS_E_LIMIT] = "over the limit",
    [QS_E_OVERFLOW] = "the costs are too large: they do not fit",
    [QS_E_FORMAT] = "not a file of this format",
    [QS_E_UNSUPPORTED] = "of a newer version, or with a feature that this version does not know",
    [QS_E_CORRUPT] = "damaged",
    [QS_E_TRUNCATED] = "cut short",
    [QS_E_IO] = "cannot be written",
    [QS_E_GEOMETRY] = "pictures, window and labels do not fit each other",
    [QS_E_ENCODING] = "the encoding cannot hold this pairwise cost",
    [QS_E_INFEASIBLE] = "the sample is not a labelling",
};

const char *qs_status_text(qs_status status)
{
    size_t at = (size_t)status;
    return at < sizeof texts / sizeof texts[0] ? texts[at] : "unknown status";
}
