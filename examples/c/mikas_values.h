/* Values of the parameters (docs/protocol.md, §4) in C99, without a library. */
#ifndef MIKAS_VALUES_H
#define MIKAS_VALUES_H

#include <stdint.h>

enum mikas_kind { MIKAS_BYTE, MIKAS_SIGNED, MIKAS_WORD, MIKAS_FLAG };

struct mikas_parameter {
    const char *name;
    uint8_t code;
    enum mikas_kind kind;
    uint8_t mask;           /* of a flag */
    double divisor, offset; /* value = raw / divisor + offset */
};

/* Return the parameter of this name, or NULL. */
const struct mikas_parameter *mikas_parameter(const char *name);

/* Return how many bytes its datum has. */
int mikas_size(const struct mikas_parameter *parameter);

/* Return the value of a datum, its first byte as it came first; of a flag 0 or 1. */
double mikas_value(const struct mikas_parameter *parameter, const uint8_t *datum);

#endif
