/* qstereo: labelling problems of computer vision as QUBOs for quantum
 * annealers.
 *
 * The whole library in one include. The stages, in the order of the data; each
 * sees only those before it:
 *
 *   status    what can go wrong               problem   sites, labels, costs,
 * the energy F stream    where bytes go                  stereo    a problem
 * from two pictures image     pictures to grey                encode    a
 * problem into the bytes of a .qcf digest    SHA-256 qubo      those bytes read
 * back: the QUBO, its energy H score     disparity maps and errors       sample
 * bits to labels, feasibility, repair samples   the bytes of a .qsf, written
 * and read
 *
 * Common to all: the library allocates nothing, does no I/O, keeps no state
 * (every function may run in any thread at any time on its own arguments) and
 * uses integers only. Pointers are borrowed for the call, unless the comment
 * says that a view keeps them. Where a call fails its outputs are as they were,
 * unless its comment says otherwise. */
#ifndef QSTEREO_H
#define QSTEREO_H

#include "qstereo/coding.h"
#include "qstereo/digest.h"
#include "qstereo/encode.h"
#include "qstereo/image.h"
#include "qstereo/labels.h"
#include "qstereo/limits.h"
#include "qstereo/model.h"
#include "qstereo/problem.h"
#include "qstereo/qubo.h"
#include "qstereo/recode.h"
#include "qstereo/reduce.h"
#include "qstereo/sample.h"
#include "qstereo/samples.h"
#include "qstereo/score.h"
#include "qstereo/solve.h"
#include "qstereo/status.h"
#include "qstereo/stereo.h"
#include "qstereo/stream.h"
#include "qstereo/version.h"

#endif
