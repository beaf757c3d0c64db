# cmake -DSIZE=arm-none-eabi-size -DIMAGES=FOLDER -DSTACK=1184 -DOUTPUT=x.cpp -P client_sizes.cmake
# Writes what client_sizes.h declares; without SIZE there are no images.
include(${CMAKE_CURRENT_LIST_DIR}/../../firmware/cortex_m3/image_size.cmake)
set(text "#include \"bench/ros/client_sizes.h\"\n\nnamespace romano::bench::ros {\n\n")
foreach(part client node)
    set(size "std::nullopt")
    if(SIZE)
        image_size(${IMAGES}/footprint_${part}.elf ${STACK} flash ram)
        set(size "ClientSize{${flash}, ${ram}}")
    endif()
    string(APPEND text "const std::optional<ClientSize> size_of_${part} = ${size};\n")
endforeach()
file(WRITE ${OUTPUT} "${text}\n}  // namespace romano::bench::ros\n")
