/* qstereo: labelling problems of computer vision as QUBOs for quantum
 * annealers.
 *
 * This includes the whole library. Its stages, in the order of the data; each
 * sees only those above it:
 *
 *   version   of the library and of the files
 *   status    what can go wrong
 *   stream    where bytes go
 *   digest    SHA-256, by which samples name their problem
 *   limits    the largest numbers of everything
 *   meaning   what labels stand for
 *   problem   sites, labels, costs: the energy F of a labelling
 *   coding    how labels become bits: encodings and penalties
 *   labels    what a .qcf says of sites and labels; a labelling in its picture
 *   image     pictures to grey
 *   stereo    a problem from two grey pictures
 *   matching  the same with better costs, half pixels and weights by contrast
 *   restore   a problem from a noisy grey picture
 *   segment   a problem from a picture and strokes on it
 *   displace  a problem from two pictures: flow and registration
 *   overlap   a problem from boxes that a detector found
 *   score     a disparity map beside the true one
 *   encode    a problem as the bytes of a .qcf, row by row
 *   qubo      these bytes read back: the QUBO and its energy H
 *   sample    bits to labels: feasibility and repair
 *   samples   the bytes of a .qsf, written and read
 *   model     a problem as the solvers want it
 *   solve     classical solvers, with lower bounds
 *   maps      consistency, filling, refinement and margins of disparity maps
 *   reduce    labels that are proven to be in no optimum leave
 *   certificate  proofs of bounds and of labels that have left, written, and
 *             checked from a .qcf alone
 *   recode    a model, or what is left of it, in any encoding
 *
 * The caller brings all memory. A function says how much a call needs:
 *
 *     size_t size = qs_model_of_problem_workspace(&problem);
 *     void *memory = size < SIZE_MAX ? malloc(size) : NULL;
 *     status = qs_model_of_problem(&problem, memory, size, &model, NULL);
 *
 * Whole programs are in examples/.
 *
 * What a QUBO is and what the words mean, docs/GLOSSARY.md says.
 *
 * Common to all: the library allocates nothing, does no I/O, keeps no state and
 * uses integers only. Every function may run in any thread at any time, on its
 * own arguments. Pointers are borrowed for the call, unless the comment says
 * that a view keeps them. If a call fails, its outputs are as they were, unless
 * its comment says otherwise. */
#ifndef QSTEREO_H
#define QSTEREO_H

#include "qstereo/certificate.h"
#include "qstereo/coding.h"
#include "qstereo/digest.h"
#include "qstereo/displace.h"
#include "qstereo/encode.h"
#include "qstereo/image.h"
#include "qstereo/labels.h"
#include "qstereo/limits.h"
#include "qstereo/maps.h"
#include "qstereo/matching.h"
#include "qstereo/meaning.h"
#include "qstereo/model.h"
#include "qstereo/overlap.h"
#include "qstereo/problem.h"
#include "qstereo/qubo.h"
#include "qstereo/recode.h"
#include "qstereo/reduce.h"
#include "qstereo/restore.h"
#include "qstereo/sample.h"
#include "qstereo/samples.h"
#include "qstereo/score.h"
#include "qstereo/segment.h"
#include "qstereo/solve.h"
#include "qstereo/status.h"
#include "qstereo/stereo.h"
#include "qstereo/stream.h"
#include "qstereo/version.h"

#endif
