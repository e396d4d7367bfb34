#include "mikas_values.h"

#include <string.h>

static const struct mikas_parameter PARAMETERS[] = {
    {"TWAT", 0x1A, MIKAS_BYTE, 0, 1, -40},
    {"FREQ", 0x29, MIKAS_BYTE, 0, 1 / 40.0, 0}, /* E1 */
    {"FREQX", 0x2C, MIKAS_BYTE, 0, 1 / 10.0, 0},
    {"UOZ", 0x26, MIKAS_SIGNED, 0, 2, 0},
    {"UACC", 0x1E, MIKAS_BYTE, 0, 10, 0}, /* E2 */
    {"INJ", 0x3F, MIKAS_WORD, 0, 125, 0},
    {"JAIR", 0x21, MIKAS_WORD, 0, 100, 0},
    {"JQT", 0x40, MIKAS_WORD, 0, 10, 0},
    {"DET", 0x08, MIKAS_FLAG, 0x40, 1, 0},
    {"RXX", 0x07, MIKAS_FLAG, 0x04, 1, 0},
    {"BITPOW", 0x07, MIKAS_FLAG, 0x20, 1, 0},
    {"RDET", 0x07, MIKAS_FLAG, 0x80, 1, 0},
    {"VALF", 0x39, MIKAS_BYTE, 0, 256, 0.5},
    {"THR", 0x20, MIKAS_BYTE, 0, 1, 0},
    {"RCOK", 0x42, MIKAS_BYTE, 0, 256, -1}, /* E3, to the letter: (b - 128)/256 - 0.5 */
    {"RCOD", 0x41, MIKAS_BYTE, 0, 256, -1},
    {"UOZOC", 0x28, MIKAS_SIGNED, 0, 2, 0},
    {"SSM", 0x5B, MIKAS_BYTE, 0, 1, 0},
    {"FSM", 0x5C, MIKAS_BYTE, 0, 1, 0},
    {"MINERR", 0x72, MIKAS_BYTE, 0, 1, 0},
    {"UGB", 0x59, MIKAS_WORD, 0, 100, 0},
    {"TAIR", 0x1C, MIKAS_BYTE, 0, 1, -40}, /* E4 */
    {"TWATI", 0x19, MIKAS_BYTE, 0, 1, -40},
};

const struct mikas_parameter *mikas_parameter(const char *name)
{
    for (size_t i = 0; i < sizeof PARAMETERS / sizeof *PARAMETERS; i++)
        if (!strcmp(PARAMETERS[i].name, name))
            return &PARAMETERS[i];
    return NULL;
}

int mikas_size(const struct mikas_parameter *parameter)
{
    return parameter->kind == MIKAS_WORD ? 2 : 1;
}

double mikas_value(const struct mikas_parameter *parameter, const uint8_t *datum)
{
    int raw = datum[0];
    switch (parameter->kind) {
    case MIKAS_FLAG:
        return (raw & parameter->mask) != 0;
    case MIKAS_SIGNED:
        raw = raw < 128 ? raw : raw - 256;
        break;
    case MIKAS_WORD: /* low byte first */
        raw += 256 * datum[1];
        break;
    case MIKAS_BYTE:
        break;
    }
    return raw / parameter->divisor + parameter->offset;
}
