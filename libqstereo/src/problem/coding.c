#include "../../include/qstereo/coding.h"

#include "../../include/qstereo/limits.h"
#include "pairwise.h"

#define BIT(penalty)     (1u << (penalty))
#define PROVEN_PENALTIES (BIT(QS_PENALTY_LOCAL) | BIT(QS_PENALTY_MINIMAL))
#define ALL_PENALTIES    (PROVEN_PENALTIES | BIT(QS_PENALTY_PAPER) | BIT(QS_PENALTY_GIVEN))

#define ONE_LABEL_EACH "each site has exactly one label"
#define ONE_STEP_EACH  "each site's chain falls from 1 to 0 once, source 1, sink 0"

/* What only the library asks. */
typedef struct row {
    qs_encoding_facts facts;
    /* Which costs it holds, and how samples of each are repaired. Linear is V = |a - b|, which no
     * truncation changes; Potts of two labels is linear too. */
    bool potts, linear, truncated_linear, others;
    qs_repair repair_potts, repair_linear, repair_truncated_linear, repair_others;
} row;

static const row rows[QS_ENCODINGS] = {
    {
        .facts = {QS_ONE_HOT, "one-hot", "any smoothness", ONE_LABEL_EACH, ALL_PENALTIES,
                  ALL_PENALTIES, QS_CODE_ONE_HOT, QS_NO_AUXILIARIES, true, true},
        .potts = true,
        .linear = true,
        .truncated_linear = true,
        .others = true,
    },
    {
        .facts = {QS_ONE_HOT_SPARSE, "one-hot-sparse", "potts and linear", ONE_LABEL_EACH,
                  ALL_PENALTIES, ALL_PENALTIES & ~BIT(QS_PENALTY_PAPER), QS_CODE_ONE_HOT,
                  QS_NO_AUXILIARIES, true, true},
        .potts = true,
        .linear = true,
        .truncated_linear = true,
        .repair_potts = QS_REPAIR_BY_LABEL_ORDER,
        .repair_linear = QS_REPAIR_SITE_BY_SITE,
        .repair_truncated_linear = QS_REPAIR_SITE_BY_SITE,
    },
    {
        .facts = {QS_DOMAIN_WALL, "domain-wall", "any smoothness",
                  "in no site a 0 stands before a 1", PROVEN_PENALTIES, PROVEN_PENALTIES,
                  QS_CODE_WALL, QS_NO_AUXILIARIES, false, true},
        .potts = true,
        .linear = true,
        .truncated_linear = true,
        .others = true,
        .repair_potts = QS_REPAIR_BY_LABEL_ORDER,
        .repair_linear = QS_REPAIR_BY_THRESHOLDS,
        .repair_truncated_linear = QS_REPAIR_SITE_BY_SITE,
        .repair_others = QS_REPAIR_BY_CHOICE,
    },
    {
        .facts = {QS_MULTIWAY_CUT, "multiway-cut", "potts",
                  "each site has exactly one label, each terminal its own", ALL_PENALTIES,
                  ALL_PENALTIES, QS_CODE_ONE_HOT, QS_TERMINALS, false, false},
        .potts = true,
    },
    {
        .facts = {QS_ST_CUT, "st-cut", "linear smoothness without truncation", ONE_STEP_EACH,
                  PROVEN_PENALTIES, PROVEN_PENALTIES, QS_CODE_CHAIN, QS_SOURCE_AND_SINK, false,
                  false},
        .linear = true,
        .repair_potts = QS_REPAIR_BY_THRESHOLDS,
        .repair_linear = QS_REPAIR_BY_THRESHOLDS,
    },
    {
        .facts = {QS_ST_CUT_ARCS, "st-cut-arcs", "linear smoothness without truncation",
                  ONE_STEP_EACH, PROVEN_PENALTIES, PROVEN_PENALTIES, QS_CODE_CHAIN,
                  QS_SOURCE_SINK_AND_ARCS, false, false},
        .linear = true,
        .repair_potts = QS_REPAIR_BY_THRESHOLDS,
        .repair_linear = QS_REPAIR_BY_THRESHOLDS,
    },
};

/* NULL = no encoding. */
static const row *row_of(qs_encoding encoding)
{
    unsigned at = (unsigned)encoding - 1;
    return at < QS_ENCODINGS ? &rows[at] : NULL;
}

const qs_encoding_facts *qs_encoding_facts_of(qs_encoding encoding)
{
    const row *r = row_of(encoding);
    return r ? &r->facts : NULL;
}

/* ---- What goes with what. ---- */

qs_encoding qs_encoding_default(const qs_pairwise *pairwise)
{
    return pairwise->smoothness == QS_POTTS ? QS_ONE_HOT_SPARSE : QS_ONE_HOT;
}

bool qs_encoding_holds(qs_encoding encoding, const qs_pairwise *pairwise, uint32_t labels)
{
    const row *r = row_of(encoding);
    if (!r) {
        return false;
    }
    switch (pairwise->smoothness) {
    case QS_POTTS: return r->potts || (r->linear && labels <= 2);
    case QS_TRUNCATED_LINEAR:
        return qs_is_linear(pairwise, labels) ? r->linear : r->truncated_linear;
    case QS_TRUNCATED_QUADRATIC:
    case QS_TABLE:
    case QS_TABLES: break;
    }
    return r->others;
}

bool qs_encoding_has_penalty(qs_encoding encoding, qs_penalty penalty)
{
    const row *r = row_of(encoding);
    return r && penalty <= QS_PENALTY_MINIMAL &&
           ((r->facts.penalties_of_potts | r->facts.penalties_of_others) & BIT(penalty)) != 0;
}

bool qs_encoding_allows_penalty(qs_encoding encoding, qs_penalty penalty,
                                const qs_pairwise *pairwise)
{
    const row *r = row_of(encoding);
    if (!r || penalty > QS_PENALTY_MINIMAL) {
        return false;
    }
    bool potts = pairwise->smoothness == QS_POTTS;
    return ((potts ? r->facts.penalties_of_potts : r->facts.penalties_of_others) & BIT(penalty)) !=
           0;
}

bool qs_penalty_keeps_gap(qs_penalty penalty)
{
    return penalty <= QS_PENALTY_MINIMAL && (PROVEN_PENALTIES & BIT(penalty)) != 0;
}

qs_repair qs_encoding_repair(qs_encoding encoding, qs_penalty penalty, const qs_pairwise *pairwise,
                             uint32_t labels)
{
    const row *r = row_of(encoding);
    bool improved_by_flips = r && r->facts.code == QS_CODE_ONE_HOT && penalty != QS_PENALTY_MINIMAL;
    if (!r || improved_by_flips) {
        return QS_REPAIR_BY_FLIPS;
    }
    if (pairwise->smoothness == QS_POTTS) {
        return r->repair_potts;
    }
    if (pairwise->smoothness != QS_TRUNCATED_LINEAR) {
        return r->repair_others;
    }
    return qs_is_linear(pairwise, labels) ? r->repair_linear : r->repair_truncated_linear;
}

qs_status qs_encode_settle(const qs_encode_options *options, const qs_pairwise *pairwise,
                           uint32_t labels, qs_encode_options *settled)
{
    qs_encode_options own = *options;
    bool given = own.penalty == QS_PENALTY_GIVEN;
    if (own.encoding == QS_ENCODING_DEFAULT) {
        own.encoding = qs_encoding_default(pairwise);
    }
    if (own.gap == 0 || !qs_penalty_keeps_gap(own.penalty)) {
        own.gap = 1;
    }
    if (!row_of(own.encoding) || own.penalty > QS_PENALTY_MINIMAL || options->gap > INT32_MAX ||
        (given && own.alpha <= 0)) {
        return QS_E_ARGUMENT;
    }
    if (given && own.alpha > QS_ENERGY_MAX) {
        return QS_E_OVERFLOW;
    }
    if (!qs_encoding_holds(own.encoding, pairwise, labels) ||
        !qs_encoding_allows_penalty(own.encoding, own.penalty, pairwise)) {
        return QS_E_ENCODING;
    }
    *settled = own;
    return QS_OK;
}

/* ---- Sizes. ---- */

uint32_t qs_encoding_site_variables(qs_encoding encoding, uint32_t labels)
{
    const row *r = row_of(encoding);
    switch (r ? r->facts.code : QS_CODE_ONE_HOT) {
    case QS_CODE_WALL: return labels - 1;
    case QS_CODE_CHAIN: return labels + 1;
    case QS_CODE_ONE_HOT: break;
    }
    return labels;
}

/* Groups of one variable, each edge of the graph a coupling. An arc's variable is coupled with both
 * ends of its edge, and these with each other: five couplings for two arcs. */
static qs_encoding_size measure_cut(const qs_encoding_counts *c, bool arcs)
{
    uint64_t vertices = c->labels_left + c->undecided + 2,
             edges = 2 * c->undecided + c->labels_left + c->thresholds,
             variables = arcs ? vertices + 2 * edges : vertices;
    return (qs_encoding_size){variables, variables, arcs ? 5 * edges : edges};
}

qs_encoding_size qs_encoding_measure(qs_encoding encoding, const qs_encoding_counts *c)
{
    const qs_encoding_facts *facts = qs_encoding_facts_of(encoding);
    uint64_t k = c->labels;
    qs_encoding_size size = {c->labels_left, c->undecided, c->edges};
    if (!facts || c->undecided == 0) {
        return size;
    }
    if (facts->code == QS_CODE_CHAIN) {
        return measure_cut(c, facts->auxiliaries == QS_SOURCE_SINK_AND_ARCS);
    }
    if (facts->code == QS_CODE_WALL) {
        size.variables -= c->undecided;
        size.couplings += c->undecided; /* each chain with itself */
    }
    if (facts->auxiliaries == QS_TERMINALS) {
        size.variables += k * k;
        size.groups += k;
        size.couplings += c->labels_left;
    }
    return size;
}
