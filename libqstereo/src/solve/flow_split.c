#include "flow_split.h"

#include <string.h>

/* The edge of a chain at a site that leads to a later site, or to an earlier one: qs_witness says
 * how chains are numbered. Of a graph this is the next one; `at` goes on from chain to chain. */
static bool see_edge_of_chain(const qs_model *model, uint32_t site, uint32_t chain, bool first,
                              uint32_t *at, qs_edge_seen *edge)
{
    bool grid = model->width > 0;
    *at = grid ? 0 : *at;
    while (qs_see_edge(model, site, (*at)++, edge)) {
        if (edge->weight > 0 && edge->first == first &&
            (!grid || chain == (qs_is_vertical(edge) ? 1 : 0))) {
            return true;
        }
    }
    return false;
}

static void tell_site(const qs_flow_split *split, const qs_witness *witness, uint32_t site,
                      qs_edge_takes *takes, const void *context)
{
    const qs_model *model = split->model;
    uint32_t at[] = {0, 0}; /* of the edges to earlier sites, and to later ones */
    bool any = true;
    for (uint32_t chain = 0; any; chain++) {
        qs_edge_seen edge;
        any = model->width > 0 && chain < 2;
        memset(split->sum, 0, sizeof *split->sum * model->labels);
        for (int first = 0; first < 2; first++) {
            if (see_edge_of_chain(model, site, chain, first != 0, &at[first], &edge)) {
                takes(context, site, at[first] - 1, &edge, split->sum);
                any = true;
            }
        }
        if (any) {
            witness->share(witness->context, model, site, chain, split->sum, sizeof *split->sum);
        }
    }
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
        tell_site(split, witness, p, takes, context);
    }
    witness->end(witness->context, model->kept);
}

void qs_flow_split_none(const qs_model *model, const qs_witness *witness, const uint16_t *labelling)
{
    if (witness) {
        witness->end(witness->context, model->kept); /* what has left, has left without it */
        witness->split(witness->context, model, 0, labelling);
    }
}
