#pragma once

namespace mlic {

// The files of the report's page (page/), compiled in by cmake/embed_texts.cmake.
extern const char kPageHtml[];
extern const char kStyleCss[];
extern const char kReportJs[];   // choices, sliders and copying
extern const char kRigViewJs[];  // the turnable drawing
extern const char kThreeNotice[];
// three.js as it was where MLIC was built; empty where it was not installed.
extern const char kThreeJs[];

}  // namespace mlic
