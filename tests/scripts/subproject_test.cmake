# ilss as a part of another project, by add_subdirectory: cmake -D SOURCE_DIR=... -D WORK_DIR=...
# -P this file. It compiles the framework, so .ci/run calls it, not the tests.
function(run result)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output
                  ERROR_VARIABLE error)
  if(NOT status STREQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${status}:\n${output}${error}")
  endif()
  set(${result} "${output}" PARENT_SCOPE)
endfunction()

run(_ ${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR}/tests/scripts/subproject -B ${WORK_DIR}
      -D ILSS_SOURCE_DIR=${SOURCE_DIR} -D CMAKE_UNITY_BUILD=ON -D CMAKE_UNITY_BUILD_BATCH_SIZE=6)
run(_ ${CMAKE_COMMAND} --build ${WORK_DIR})
file(GLOB_RECURSE programs ${WORK_DIR}/another)
run(angle ${programs})
if(NOT angle STREQUAL "3.14159\n")
  message(FATAL_ERROR "180 deg are ${angle}rad there")
endif()
