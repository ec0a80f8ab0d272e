/* Certificates, .qpf: proofs that others can check (docs/FORMAT.md, section
 * 4). A certificate belongs to one .qcf. It states a lower bound of all
 * labellings, and a labelling with its energy; and, for a problem that was
 * reduced, which labels are in no optimum. It holds the numbers that prove it.
 *
 * The checker reads the coefficients of the .qcf by itself. It shares no code
 * with the solvers: what they call proven, it computes again by dynamic
 * programs along chains, and by elimination in parts that are narrow
 * (docs/MATHS.md, section 19). */
#ifndef QSTEREO_CERTIFICATE_H
#define QSTEREO_CERTIFICATE_H

#include "digest.h"
#include "reduce.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Reading and checking. ---- */

/* A .qpf in memory. It borrows the file's bytes. */
typedef struct qs_certificate {
    uint32_t sites; /* undecided sites of the problem */
    uint32_t stages;
    int64_t lower_bound; /* that it states; QS_NO_BOUND = none */
    int64_t energy; /* that it states of its labelling */
    const uint8_t *problem; /* digest of the .qcf, QS_DIGEST_SIZE bytes */
    unsigned label_bytes; /* of a label, 1 or 2 */
    /* For the checker: of each undecided site a label, and the stages. */
    const uint8_t *labelling, *stage_bytes;
    uint64_t stage_size;
    uint64_t stage_offset; /* in the file, for messages */
} qs_certificate;

/* Opens a .qpf in memory. Checks the container and the size of what does not
 * depend on the problem; qs_certificate_check checks the rest.
 *
 * bytes        the whole file; the view borrows it
 * certificate  out
 * fault        out if the file is refused, may be NULL
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT     a null pointer
 *   QS_E_FORMAT       not a .qpf
 *   QS_E_TRUNCATED    cut short
 *   QS_E_CORRUPT      damaged
 *   QS_E_UNSUPPORTED  of a newer version */
QS_MUST_CHECK qs_status qs_certificate_open(const void *bytes, size_t size,
                                            qs_certificate *certificate,
                                            qs_fault *fault);

/* What checking a certificate has found. */
typedef struct qs_verdict {
    bool valid; /* all that the certificate states is so */
    const char *why; /* if it is not valid, what is wrong; static text */
    uint32_t stage; /* the stage that it is wrong in, if any: counted from 0 */
    int64_t lower_bound; /* that the certificate proves, which may be above what
                            it states. QS_NO_BOUND = none */
    int64_t energy; /* of its labelling */
    uint32_t undecided; /* sites that two labels or more are left to */
    uint64_t labels; /* left to these */
} qs_verdict;

/* Bytes of workspace for qs_certificate_check: about 8 bytes for each label of
 * each coupling, and up to 160 MB for the tables of solved parts. */
size_t qs_certificate_workspace(const qs_index *index);

/* Checks a certificate: goes through its stages, each of which proves a bound,
 * or labels in no optimum, or both, for the labels that the stages before it
 * have left.
 *
 * index      of the .qcf
 * workspace  aligned for any type
 * verdict    out
 * left       out, may be NULL: of each label of each undecided site, one after
 *            another, 1 = it is left. Only if the certificate is valid
 * fault      out if the file is refused, may be NULL
 *
 * Returns
 *   QS_OK             the verdict says whether it is valid
 *   QS_E_ARGUMENT     a null pointer
 *   QS_E_WORKSPACE
 *   QS_E_UNSUPPORTED  the .qcf does not say what its variables mean
 *   QS_E_ENCODING     the .qcf is not one-hot, one-hot-sparse or domain-wall
 *   QS_E_CORRUPT      a stage is malformed
 *   QS_E_OVERFLOW     its numbers are too large for 64 bits */
QS_MUST_CHECK qs_status qs_certificate_check(
    const qs_index *index, const qs_certificate *certificate, void *workspace,
    size_t workspace_size, qs_verdict *verdict, uint8_t *left, qs_fault *fault);

/* Returns true if a reduced problem has all labels that a certificate leaves:
 * no label has left it that is not proven to be in no optimum. What its labels
 * cost is not compared.
 *
 * qubo     of the whole problem
 * left     of qs_certificate_check
 * smaller  the reduced problem, in any encoding */
bool qs_certificate_covers(const qs_qubo *qubo, const uint8_t *left,
                           const qs_qubo *smaller);

/* ---- Writing. ---- */

/* Takes down what a solver proves. Its fields are the library's. */
typedef struct qs_recorder {
    const qs_index *index;
    const qs_model *model;
    const qs_sink *sink;
    struct qs_record_book *book;
    uint32_t stages;
    bool has_refused; /* after qs_recorder_end: a part was too wide to be solved
                         in a certificate, and not all is proven */
    qs_status status;
} qs_recorder;

/* Bytes of workspace for qs_recorder_begin. */
size_t qs_recorder_workspace(const qs_index *index, const qs_model *model);

/* Begins to record. Give qs_recorder_witness of it to qs_trws, qs_best or
 * qs_reduce.
 *
 * index      of the .qcf
 * model      of the same; all three are borrowed until qs_recorder_end
 * workspace  aligned for any type
 * stages     takes the stages as they come; the caller keeps them for
 *            qs_certificate_write
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT   a null pointer
 *   QS_E_WORKSPACE
 *   QS_E_ENCODING   two couplings join the same two groups: their chains would
 *                   not be told apart
 *   QS_E_LIMIT      a site of a graph has more than 65536 neighbours before it,
 *                   or behind it: a file numbers them by 2 bytes */
QS_MUST_CHECK qs_status qs_recorder_begin(
    qs_recorder *recorder, const qs_index *index, const qs_model *model,
    void *workspace, size_t workspace_size, const qs_sink *stages);

/* The witness that records. It borrows the recorder. */
qs_witness qs_recorder_witness(qs_recorder *recorder);

/* Ends recording.
 *
 * Returns
 *   QS_OK
 *   QS_E_IO         the sink refused bytes
 *   QS_E_OVERFLOW   a share, or a cost that was to be folded, is too large, or
 *                   there are more than 4096 stages
 *   QS_E_ENCODING   the solver has told nothing: it is none that calls a
 *                   witness */
QS_MUST_CHECK qs_status qs_recorder_end(qs_recorder *recorder);

/* Writes a .qpf.
 *
 * labelling    the best one known: of the problem's sites, as qs_sample_decode
 *              has it
 * lower_bound  to be stated. QS_NO_BOUND = none
 * energy       of the labelling
 * stages       what the recorder's sink has taken
 * sink         NULL = nothing is written: a sizing pass
 * size         out, may be NULL: bytes of the file
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a label that there is not
 *   QS_E_IO        the sink refused bytes */
QS_MUST_CHECK qs_status
qs_certificate_write(const qs_recorder *recorder, const uint16_t *labelling,
                     int64_t lower_bound, int64_t energy, const uint8_t *stages,
                     size_t stages_size, const qs_sink *sink, uint64_t *size);

#ifdef __cplusplus
}
#endif

#endif
