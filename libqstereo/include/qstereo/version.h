/* The version of the library and, apart from it, the version of the file
 * formats that it writes and reads. */
#ifndef QSTEREO_VERSION_H
#define QSTEREO_VERSION_H

#define QS_VERSION_MAJOR 0
#define QS_VERSION_MINOR 2
#define QS_VERSION_PATCH 0
#define QS_VERSION       "0.2.0"

/* Of both .qcf and .qsf (docs/FORMAT.md). */
#define QS_FORMAT_VERSION 1

#endif
