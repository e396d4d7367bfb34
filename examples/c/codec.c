/* The codec as a program: conformance/run.py describes its lines. */
#include "mikas_frames.h"
#include "mikas_values.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_LINE = 16384 };

static int hex_byte(const char **text, uint8_t *byte)
{
    while (isspace((unsigned char)**text) || **text == '|')
        ++*text;
    if (!isxdigit((unsigned char)(*text)[0]) || !isxdigit((unsigned char)(*text)[1]))
        return 0;
    char digits[3] = {(*text)[0], (*text)[1], 0};
    *byte = (uint8_t)strtoul(digits, NULL, 16);
    *text += 2;
    return 1;
}

static void print_bytes(const char *what, const uint8_t *bytes, size_t count)
{
    fputs(what, stdout);
    for (size_t i = 0; i < count; i++)
        printf("%s%02X", i || *what ? " " : "", bytes[i]);
}

static void decode(const char *text)
{
    static struct mikas_decoder decoder;
    const char *between = "";
    uint8_t byte;
    mikas_begin(&decoder);
    while (hex_byte(&text, &byte)) {
        int again = 1;
        while (again) {
            enum mikas_event event = mikas_feed(&decoder, byte, &again);
            if (event == MIKAS_NOTHING)
                continue;
            fputs(between, stdout);
            print_bytes(event == MIKAS_FRAME ? "frame" : "damaged", decoder.data, decoder.length);
            between = " ; ";
        }
    }
    if (decoder.count > 0) {
        fputs(between, stdout);
        print_bytes("left", decoder.bytes, decoder.count);
        if (decoder.held)
            fputs(" 0D", stdout);
    }
}

static void print_value(const char *text)
{
    char name[16];
    uint8_t datum[2];
    int length = 0, count = 0;
    const struct mikas_parameter *parameter = NULL;
    if (sscanf(text, "%15s%n", name, &length) == 1)
        parameter = mikas_parameter(name);
    text += length;
    while (count < 2 && hex_byte(&text, &datum[count]))
        count++;
    if (!parameter || count != mikas_size(parameter))
        putchar('?');
    else if (parameter->kind == MIKAS_FLAG)
        fputs(mikas_value(parameter, datum) != 0 ? "yes" : "no", stdout);
    else
        printf("%.9g", mikas_value(parameter, datum));
}

int main(void)
{
    static char line[LONGEST_LINE];
    static uint8_t body[LONGEST_LINE / 2], wire[LONGEST_LINE + 3];
    while (fgets(line, sizeof line, stdin)) {
        char *rest = strchr(line, ' ');
        size_t word = rest ? (size_t)(rest - line) : strcspn(line, "\n");
        const char *text = line + word;
        size_t count = 0;
        if (word == 6 && !strncmp(line, "decode", 6)) {
            decode(text);
        } else if (word == 5 && !strncmp(line, "value", 5)) {
            print_value(text);
        } else if (word < 6 || strncmp(line, "encode", 6)) {
            putchar('?');
        } else {
            int raw = word == 10 && !strncmp(line, "encode-raw", 10);
            while (hex_byte(&text, &body[count]))
                count++;
            print_bytes("", wire, mikas_encode(body, count, raw, wire));
        }
        putchar('\n');
        fflush(stdout);
    }
    return 0;
}
