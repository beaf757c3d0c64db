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
if(RUN_CLANG_TIDY)
    add_custom_target(tidy
        COMMAND ${RUN_CLANG_TIDY} -quiet -p ${PROJECT_BINARY_DIR}
                "^${PROJECT_SOURCE_DIR}/(broker|election|romano|firmware|overlay|experiments|bench|tests)/"
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL)
endif()
