# Formatting is a test (`format`); clang-tidy is a target: cmake --build --preset dev --target tidy

file(GLOB_RECURSE lint_files CONFIGURE_DEPENDS
     broker/*.h broker/*.cpp election/*.h election/*.cpp romano/*.h romano/*.cpp firmware/*.h firmware/*.cpp
     overlay/*.h overlay/*.cpp experiments/*.h experiments/*.cpp bench/*.h bench/*.cpp tests/*.h tests/*.cpp)

find_program(CLANG_FORMAT NAMES clang-format-14 clang-format)
if(CLANG_FORMAT AND ROMANO_TESTS)
    add_test(NAME format COMMAND ${CLANG_FORMAT} --dry-run --Werror ${lint_files}
             WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
endif()

find_program(RUN_CLANG_TIDY NAMES run-clang-tidy-14 run-clang-tidy)
find_program(CLANG_TIDY NAMES clang-tidy-14 clang-tidy)
if(NOT RUN_CLANG_TIDY OR NOT CLANG_TIDY)
    return()
endif()

# What only the microcontroller's compiler builds is in no compile_commands.json.
if(ARM_NONE_EABI_CXX)
    file(GLOB_RECURSE chip_files CONFIGURE_DEPENDS firmware/cortex_m3/*.cpp)
    execute_process(COMMAND ${ARM_NONE_EABI_CXX} -mcpu=cortex-m3 -mthumb -E -v -x c++ /dev/null
                    ERROR_VARIABLE said OUTPUT_QUIET)
    string(REGEX MATCHALL "\n /[^\n ]+/include[^\n ]*" chip_includes "${said}")
    list(TRANSFORM chip_includes REPLACE "\n " "-isystem")
    set(tidy_chip COMMAND ${CLANG_TIDY} --quiet ${chip_files} --
        --target=thumbv7m-none-eabi -mcpu=cortex-m3 -std=c++20 -ffreestanding -fno-exceptions
        -fno-rtti -nostdinc ${chip_includes} -I${PROJECT_SOURCE_DIR})
endif()

# Reads headers that a build generates: build first.
add_custom_target(tidy
    ${tidy_chip}
    COMMAND ${RUN_CLANG_TIDY} -quiet -p ${PROJECT_BINARY_DIR}
            "^${PROJECT_SOURCE_DIR}/(broker|election|romano|firmware|overlay|experiments|bench|tests)/"
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL)
