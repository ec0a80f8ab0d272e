/* What is done with disparity maps after the labels are found: matches that do
 * not agree leave, holes are filled, values become finer, and each pixel says
 * how sure it is.
 *
 * Maps are width x height values, row after row without gaps, in parts of a
 * pixel: `unit` of them are one pixel. QS_NO_DISPARITY = no value. */
#ifndef QSTEREO_MAPS_H
#define QSTEREO_MAPS_H

#include "model.h"
#include "score.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Left-right consistency (Fua 1993): a pixel of the left map keeps its value d
 * only if the right map has a value at x - d, the next whole pixel (of two, the
 * right one), and both differ by at most `tolerance`.
 *
 * left, right  the maps of the left picture, in which x matches x - d, and of
 *              the right one, in which x matches x + d. `left` is changed
 * unit         1 .. 65536
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a unit out of range */
QS_MUST_CHECK qs_status qs_map_check(int32_t *left, const int32_t *right,
                                     size_t width, size_t height, uint32_t unit,
                                     uint32_t tolerance);

/* Fills holes: a pixel without a value takes the smaller one of the nearest
 * values to its left and to its right in its row, because what one picture
 * alone sees is mostly behind its surroundings. Where there is only one it
 * takes that; a row without any value stays as it is.
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer */
QS_MUST_CHECK qs_status qs_map_fill(int32_t *values, size_t width,
                                    size_t height);

/* The median of the values in the 3 x 3 pixels about each one; of an even
 * number of values the lower middle one. A pixel without a value stays so.
 *
 * out  not `values`
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or out is values */
QS_MUST_CHECK qs_status qs_map_median(const int32_t *values, size_t width,
                                      size_t height, int32_t *out);

enum { QS_REFINED_UNIT = 16 };

/* The map of a labelling in sixteenths of a pixel: each value goes to the least
 * of the parabola through the unary costs of its label and of the two beside
 * it, at most half a label away. Where the label has no two labels beside it,
 * or costs more than one of them, it stays. (Scharstein and Szeliski 2002,
 * section 3.4.)
 *
 * model, labels  of the problem, as qs_model_of_problem makes them
 * labelling      a label of each of labels->sites
 * values         out: frame.picture_width x frame.picture_height, as
 *                qs_map_of_labelling has them
 *
 * Returns what qs_map_of_labelling does, and QS_E_ARGUMENT if the labels are no
 * disparities of 1, 1 / 2, 1 / 4, 1 / 8 or 1 / 16 pixel. */
QS_MUST_CHECK qs_status qs_map_refine(const qs_model *model,
                                      const qs_labels *labels,
                                      const uint16_t *labelling,
                                      int32_t *values);

/* How sure each site of a grid is: its margin, the energy that its row at least
 * costs more if the site has a label that is another answer, while all sites of
 * the row take their best labels and edges to other rows count nothing. That is
 * the difference of two min-marginals of a chain. The same of its column, and
 * the smaller one counts. It is 0 where another answer costs no more. (Margins
 * of min-marginals as a measure of confidence: Kohli and Torr 2008.)
 *
 * labelling  of the model's sites
 * apart      labels that differ by at most so much are one answer
 * workspace  qs_margins_workspace bytes, aligned for any type
 * margins    out: the model's sites; UINT32_MAX where there is no other answer
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a label that there is not
 *   QS_E_GEOMETRY  the model is not a grid
 *   QS_E_WORKSPACE
 *   QS_E_OVERFLOW  the costs are too large for sums of 32 bits */
QS_MUST_CHECK qs_status qs_margins(const qs_model *model,
                                   const uint16_t *labelling, uint32_t apart,
                                   void *workspace, size_t workspace_size,
                                   uint32_t *margins);
size_t qs_margins_workspace(const qs_model *model);

/* The mean of the numbers in the 3 x 3 pixels about each one, rounded up; a
 * pixel with 0 keeps it. Margins that are evened out like this sort the errors
 * of a map better, because wrong pixels that are sure of themselves stand among
 * others that are not.
 *
 * out  not `values`
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or out is values */
QS_MUST_CHECK qs_status qs_map_mean(const uint16_t *values, size_t width,
                                    size_t height, uint16_t *out);

#ifdef __cplusplus
}
#endif

#endif
