#pragma once

// The assembler takes files in as they are: as a C++ array half a megabyte would take the compiler
// seconds. NOLINTBEGIN(cppcoreguidelines-macro-usage): only a preprocessor can put a path into an
// assembler directive

/// Declares terravox_page_SYMBOL_begin and terravox_page_SYMBOL_end, between which the bytes of a
/// file lie.
#define TERRAVOX_EMBED(symbol, file)                           \
    asm(".pushsection .rodata.terravox_page,\"a\",@progbits\n" \
        ".global terravox_page_" #symbol                       \
        "_begin\n"                                             \
        ".global terravox_page_" #symbol                       \
        "_end\n"                                               \
        "terravox_page_" #symbol                               \
        "_begin:\n"                                            \
        ".incbin \"" file                                      \
        "\"\n"                                                 \
        "terravox_page_" #symbol                               \
        "_end:\n"                                              \
        ".byte 0\n"                                            \
        ".popsection\n");                                      \
    extern "C" const char terravox_page_##symbol##_begin[], terravox_page_##symbol##_end[]
// NOLINTEND(cppcoreguidelines-macro-usage)
