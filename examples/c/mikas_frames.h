/* Messages of the Mikas 5.4 and 7.1 units (docs/protocol.md, §2) in C99, without a library.
 *
 * Made from that page alone. mikas_frames.c is the codec, mikas_values.c has the values of the
 * parameters (§4), codec.c is the program that conformance/run.py asks:
 *
 *     cd examples/c
 *     cc -std=c99 -Wall -Wextra -O2 -o codec codec.c mikas_frames.c mikas_values.c
 *     python3 ../../conformance/run.py ./codec
 */
#ifndef MIKAS_FRAMES_H
#define MIKAS_FRAMES_H

#include <stddef.h>
#include <stdint.h>

/* The longest messages: a request of 519 bytes on the wire (26 with 255 bytes, all of them
 * stuffed), a response of 1,023 (255 data of two bytes); §2.4. */
enum { MIKAS_LONGEST = 1024 };

/* Write the message of `body` to `wire`, which has room for 2 * length + 3 bytes; return its
 * length. `raw_checksum`: a checksum 0D or 40 is not stuffed (D3). */
size_t mikas_encode(const uint8_t *body, size_t length, int raw_checksum, uint8_t *wire);

enum mikas_event {
    MIKAS_NOTHING, /* more bytes are needed, or a bare 0D was skipped (D5) */
    MIKAS_FRAME,   /* `data`, `length`: the body of a whole message */
    MIKAS_DAMAGED  /* `data`, `length`: the bytes before the 0D, as received */
};

struct mikas_decoder {
    uint8_t bytes[MIKAS_LONGEST]; /* of the message that arrives, as received */
    size_t count;
    uint8_t sum;
    int held;     /* a 0D has come that is perhaps the checksum (D3) */
    int overlong; /* more than MIKAS_LONGEST bytes without a 0D: dropped up to it */
    uint8_t data[MIKAS_LONGEST];
    size_t length;
};

void mikas_begin(struct mikas_decoder *decoder);

/* Take one byte. If it returns MIKAS_DAMAGED with `*again` set, the byte belongs to the next
 * message and has to be given once more. */
enum mikas_event mikas_feed(struct mikas_decoder *decoder, uint8_t byte, int *again);

#endif
