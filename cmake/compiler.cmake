# How everything is compiled: warnings, sanitizers, ccache.

add_compile_options(-pipe)  # no temporary files: what the assembler gets of a sanitized test is large

add_library(project_warnings INTERFACE)
target_compile_options(project_warnings INTERFACE
    -Wall -Wextra -Wconversion -Wshadow -Wundef -Werror
    $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor;-Wold-style-cast>)

if(ROMANO_SANITIZE)
    add_compile_options(-fsanitize=${ROMANO_SANITIZE} -fno-omit-frame-pointer)
    add_link_options(-fsanitize=${ROMANO_SANITIZE})
    if(ROMANO_SANITIZE MATCHES "undefined")
        add_compile_options(-fno-sanitize-recover=undefined)
    endif()
    # ThreadSanitizer does not see Asio's fences. It need not: Asio's mutexes order what they do.
    if(ROMANO_SANITIZE MATCHES "thread" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-Wno-tsan>)
    endif()
endif()

if(ROMANO_FUZZERS)  # coverage in all code; the fuzzers themselves add libFuzzer's main
    add_compile_options(-fsanitize=fuzzer-no-link)
endif()

find_program(CCACHE ccache)
if(CCACHE)
    set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()
