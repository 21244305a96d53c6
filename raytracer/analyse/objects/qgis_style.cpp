#include "raytracer/analyse/objects/qgis_style.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "raytracer/analyse/report/band_style.hpp"

namespace terravox::analyse {
namespace {

constexpr int kSteps = 6;

template <class... Values>
std::string formatted(const char* form, Values... values) {
    std::array<char, 512> text{};
    std::snprintf(text.data(), text.size(), form, values...);
    return text.data();
}

/// Borders of the steps, whole numbers where the values allow it.
struct Steps {
    double low = 0;
    double width = 1;
    [[nodiscard]] double border(int i) const noexcept { return low + width * i; }
};

Steps steps_of(const std::vector<double>& kwh_m2) {
    const auto [first, last] = std::minmax_element(kwh_m2.begin(), kwh_m2.end());
    const double least = kwh_m2.empty() ? 0 : *first;
    const double most = kwh_m2.empty() ? 0 : *last;
    constexpr double kUneven = kSteps * 2;
    // Of a single day energies differ by less than the steps of whole numbers.
    const double unit = most - least > kUneven ? 1 : 0.01;
    Steps out;
    out.low = std::floor(least / unit) * unit;
    out.width = std::max(std::ceil((most - out.low) / kSteps / unit), 1.0) * unit;
    return out;
}

std::string range_of(const Steps& steps, int i) {
    const double low = steps.border(i);
    const double high = steps.border(i + 1);
    return formatted(
        "<range lower=\"%.6f\" upper=\"%.6f\" symbol=\"%d\" label=\"%g to %g\" render=\"true\"/>",
        low, high, i, low, high);
}

std::string symbol_of(int i, StyledShape shape) {
    const map::Rgba8 colour =
        colour_at(Ramp::kWarm, 0.25 + 0.75 * static_cast<double>(i) / (kSteps - 1));
    if (shape == StyledShape::kLine)
        return formatted(
            "<symbol type=\"line\" name=\"%d\" alpha=\"1\" clip_to_extent=\"1\">"
            "<layer class=\"SimpleLine\" enabled=\"1\" locked=\"0\" pass=\"0\">"
            "<prop k=\"line_color\" v=\"%d,%d,%d,255\"/><prop k=\"line_width\" v=\"0.8\"/>"
            "</layer></symbol>",
            i, colour.r, colour.g, colour.b);
    return formatted(
        "<symbol type=\"fill\" name=\"%d\" alpha=\"0.8\" clip_to_extent=\"1\">"
        "<layer class=\"SimpleFill\" enabled=\"1\" locked=\"0\" pass=\"0\">"
        "<prop k=\"color\" v=\"%d,%d,%d,255\"/><prop k=\"outline_color\" v=\"60,60,60,255\"/>"
        "<prop k=\"outline_width\" v=\"0.2\"/><prop k=\"style\" v=\"solid\"/></layer></symbol>",
        i, colour.r, colour.g, colour.b);
}

constexpr const char* kLabels =
    "<labeling type=\"simple\"><settings>"
    "<text-style fieldName=\"round(&quot;kwh&quot;) || ' kWh'\" isExpression=\"1\" "
    "fontSize=\"8\" textColor=\"30,30,30,255\">"
    "<text-buffer bufferDraw=\"1\" bufferSize=\"0.8\" "
    "bufferColor=\"255,255,255,220\"/></text-style>"
    "<placement placement=\"1\"/>"
    "<rendering scaleVisibility=\"1\" scaleMin=\"0\" scaleMax=\"5000\"/>"
    "</settings></labeling>";

}  // namespace

std::string qgis_style(const std::vector<double>& kwh_m2, StyledShape shape) {
    const Steps steps = steps_of(kwh_m2);
    std::string ranges;
    std::string symbols;
    for (int i = 0; i < kSteps; ++i) {
        ranges += range_of(steps, i);
        symbols += symbol_of(i, shape);
    }
    const bool has_labels = shape == StyledShape::kPolygon;
    return std::string(
               "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>"
               "<qgis version=\"3.22.0\" styleCategories=\"Symbology|Labeling\" "
               "labelsEnabled=\"") +
           (has_labels ? "1" : "0") +
           "\">"
           "<renderer-v2 type=\"graduatedSymbol\" attr=\"kwh_m2\" "
           "graduatedMethod=\"GraduatedColor\" symbollevels=\"0\" enableorderby=\"0\" "
           "forceraster=\"0\"><ranges>" +
           ranges + "</ranges><symbols>" + symbols + "</symbols></renderer-v2>" +
           (has_labels ? kLabels : "") + "</qgis>";
}

}  // namespace terravox::analyse
