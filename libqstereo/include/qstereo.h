/* qstereo: labelling problems of computer vision as QUBOs for quantum
 * annealers.
 *
 * The whole library in one include. Its parts, in the order of the data:
 *
 *   status    what can go wrong
 *   stream    where bytes go
 *   limits    of every problem and file
 *   problem   sites, labels and costs; the energy F of a labelling
 *   image     pictures to grey
 *   stereo    the problem of two pictures
 *   coding    the encodings and their penalties, and what each can hold
 *   labels    what a file says about the problem behind its QUBO
 *   encode    a problem written as a .qcf
 *   qubo      a .qcf read: the QUBO and its energy H
 *   sample    bits to labels and back; feasibility; repair
 *   samples   a .qsf, written and read
 *   digest    SHA-256, by which a .qsf names its .qcf
 *   model     a problem, from memory or from a .qcf, laid out for solvers
 *   solve     the solvers on this machine
 *   reduce    labels that are in no optimum leave a model
 *   recode    a model written as a .qcf: any encoding, only the labels left
 *   score     disparity maps of labellings, and their errors
 *   version   of the library
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
