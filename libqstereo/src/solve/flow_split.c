#include "flow_split.h"

#include <string.h>

/* The chain of an edge at a site: qs_witness says how they are numbered. `earlier` and `later`
 * count the edges of the site so far. */
static uint32_t chain_of(const qs_model *model, uint32_t site, const qs_edge_seen *edge,
                         uint32_t *earlier, uint32_t *later)
{
    if (model->width > 0) {
        uint32_t apart = edge->first ? edge->site - site : site - edge->site;
        return model->width == 1 || apart != 1;
    }
    return edge->first ? (*later)++ : (*earlier)++;
}

/* Sums up the edges of a chain at a site. Returns whether there are any. */
static bool sum_chain(const qs_flow_split *split, uint32_t site, uint32_t chain,
                      qs_edge_takes *takes, const void *context)
{
    uint32_t earlier = 0, later = 0;
    bool any = false;
    qs_edge_seen edge;
    memset(split->sum, 0, sizeof *split->sum * split->model->labels);
    for (uint32_t at = 0; qs_see_edge(split->model, site, at, &edge); at++) {
        if (edge.weight > 0 && chain_of(split->model, site, &edge, &earlier, &later) == chain) {
            takes(context, site, &edge, split->sum);
            any = true;
        }
    }
    return any;
}

void qs_flow_split_tell(const qs_flow_split *split, const qs_solve_options *options, unsigned shift,
                        const uint16_t *labelling, qs_edge_takes *takes, const void *context)
{
    const qs_model *model = split->model;
    if (!options || !options->witness) {
        return;
    }
    const qs_witness *witness = options->witness;
    witness->split(witness->context, model, shift, labelling);
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t chain = 0;; chain++) {
            bool any = sum_chain(split, p, chain, takes, context);
            if (!any && (model->width == 0 || chain > 1)) {
                break;
            }
            witness->share(witness->context, model, p, chain, split->sum, sizeof *split->sum);
        }
    }
    witness->end(witness->context, model->kept);
}
