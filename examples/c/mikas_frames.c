#include "mikas_frames.h"

#include <string.h>

enum { END = 0x0D, ESCAPE = 0x40 };

static size_t put(uint8_t byte, uint8_t *wire)
{
    if (byte == END || byte == ESCAPE) { /* §2.2: 40, then what has to be added to 40 */
        wire[0] = ESCAPE;
        wire[1] = (uint8_t)(byte - ESCAPE);
        return 2;
    }
    wire[0] = byte;
    return 1;
}

size_t mikas_encode(const uint8_t *body, size_t length, int raw_checksum, uint8_t *wire)
{
    uint8_t sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < length; i++) {
        sum = (uint8_t)(sum + body[i]);
        count += put(body[i], wire + count);
    }
    uint8_t checksum = (uint8_t)(0 - sum); /* §2.1 */
    if (raw_checksum)
        wire[count++] = checksum;
    else
        count += put(checksum, wire + count);
    wire[count++] = END;
    return count;
}

void mikas_begin(struct mikas_decoder *decoder)
{
    decoder->count = decoder->length = 0;
    decoder->sum = 0;
    decoder->held = decoder->overlong = 0;
}

static void next_message(struct mikas_decoder *decoder)
{
    decoder->count = 0;
    decoder->sum = 0;
    decoder->held = decoder->overlong = 0;
}

/* Put the message without its stuffing into `data`. A lone 40 at the end is a raw checksum (D3). */
static void unstuff(struct mikas_decoder *decoder)
{
    decoder->length = 0;
    for (size_t i = 0; i < decoder->count; i++) {
        uint8_t byte = decoder->bytes[i];
        if (byte == ESCAPE && i + 1 < decoder->count)
            byte = (uint8_t)(byte + decoder->bytes[++i]);
        decoder->data[decoder->length++] = byte;
    }
}

static enum mikas_event damaged(struct mikas_decoder *decoder)
{
    memcpy(decoder->data, decoder->bytes, decoder->count);
    decoder->length = decoder->count;
    next_message(decoder);
    return MIKAS_DAMAGED;
}

enum mikas_event mikas_feed(struct mikas_decoder *decoder, uint8_t byte, int *again)
{
    *again = 0;
    if (decoder->held) {
        if (byte != END) { /* the 0D before it was the end of a damaged message */
            *again = 1;
            return damaged(decoder);
        }
        unstuff(decoder); /* the checksum is not among the bytes */
        next_message(decoder);
        return MIKAS_FRAME;
    }
    if (byte != END) {
        if (decoder->count == MIKAS_LONGEST) {
            decoder->overlong = 1;
            return MIKAS_NOTHING;
        }
        decoder->bytes[decoder->count++] = byte;
        decoder->sum = (uint8_t)(decoder->sum + byte);
        return MIKAS_NOTHING;
    }
    if (decoder->count == 0) /* D5 */
        return MIKAS_NOTHING;
    if (decoder->overlong)
        return damaged(decoder);
    if (decoder->sum == 0) { /* §2.2: the same sum before and after stuffing */
        unstuff(decoder);
        decoder->length--; /* the checksum */
        next_message(decoder);
        return MIKAS_FRAME;
    }
    if (decoder->sum == (uint8_t)(0 - END)) {
        decoder->held = 1;
        return MIKAS_NOTHING;
    }
    return damaged(decoder);
}
