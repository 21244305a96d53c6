#include "raytracer/preview/panels/form.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "common/util/error.hpp"
#include "raytracer/preview/panels/widgets.hpp"
#include "raytracer/scene/scene_io.hpp"

namespace terravox::panels {
namespace {

struct Unit {
    std::string_view ending;
    const char* unit;
};
constexpr const char* kDegrees = "\u00b0";
constexpr std::array kUnits{Unit{"_deg", kDegrees}, Unit{"_m", "m"},      Unit{"_h", "h"},
                            Unit{"_km", "km"},      Unit{"_ev", "stops"}, Unit{"_s", "s"},
                            Unit{"_mib", "MiB"},    Unit{"_px", "px"}};

/// The number that a person means who sees so many digits: sliders have single precision.
double meant(float v) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", static_cast<double>(v));
    return std::strtod(text.data(), nullptr);
}

/// What a text field holds.
constexpr std::size_t kMaxText = 200;

std::string format_of(double low, double high, const std::string& unit) {
    const double span = high - low;
    const char* digits = span > 400 ? "%.0f" : span > 30 ? "%.1f" : "%.2f";
    return digits + (unit.empty() || unit == kDegrees ? unit : " " + unit);
}

bool is_wide(double low, double high) {
    return low >= 0 && high > 400 * std::max(low, 1.0);
}

bool number(double& value, const scene::FieldRule& rule, double low, double high,
            const std::string& unit) {
    auto v = static_cast<float>(value);
    const bool has_range = std::isfinite(low) && std::isfinite(high);
    ImGuiSliderFlags flags = ImGuiSliderFlags_None;
    if (has_range && is_wide(low, high))
        flags |= ImGuiSliderFlags_Logarithmic;
    const std::string format = format_of(low, has_range ? high : low + 100, unit);
    const bool changed = has_range
                             ? ImGui::SliderFloat("##v", &v, static_cast<float>(low),
                                                  static_cast<float>(high), format.c_str(), flags)
                             : ImGui::DragFloat("##v", &v, 0.1f, 0, 0, format.c_str());
    if (!changed)
        return false;
    value = std::clamp(meant(v), rule.min, rule.max);
    return true;
}

bool whole_number(int& value, const scene::FieldRule& rule, double low, double high) {
    const ImGuiSliderFlags flags =
        is_wide(low, high) ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None;
    if (!ImGui::SliderInt("##v", &value, static_cast<int>(low), static_cast<int>(high), "%d",
                          flags))
        return false;
    value = static_cast<int>(std::clamp(static_cast<double>(value), rule.min, rule.max));
    return true;
}

}  // namespace

SceneForm::SceneForm(scene::Scene& scene, scene::Scene& usual) : m_scene(scene) {
    scene::visit_fields(scene,
                        [this](std::string_view path, auto& field, const scene::FieldRule& rule) {
                            m_fields.emplace(path, Field{&field, &field, rule});
                        });
    scene::visit_fields(usual, [this](std::string_view path, auto& field, const scene::FieldRule&) {
        m_fields.at(path).usual = &field;
    });
}

SceneForm::Label SceneForm::label_of(std::string_view path) {
    std::string name(path.substr(path.find('.') + 1)), unit;
    for (const Unit& u : kUnits)
        if (name.size() > u.ending.size() && name.ends_with(u.ending)) {
            name.resize(name.size() - u.ending.size());
            unit = u.unit;
            break;
        }
    std::replace(name.begin(), name.end(), '_', ' ');
    return {name, unit};
}

bool SceneForm::row(std::string_view path) {
    const auto found = m_fields.find(path);
    if (found == m_fields.end())
        throw util::Error("show the field " + std::string(path) + ": no such field of a scene");
    return draw(path, found->second, found->second.rule.min, found->second.rule.max,
                std::numeric_limits<double>::quiet_NaN());
}

bool SceneForm::row(std::string_view path, double low, double high, double from) {
    const auto found = m_fields.find(path);
    if (found == m_fields.end())
        throw util::Error("show the field " + std::string(path) + ": no such field of a scene");
    return draw(path, found->second, low, high, from);
}

bool SceneForm::rows(std::initializer_list<std::string_view> paths) {
    bool changed = false;
    for (const auto path : paths)
        changed |= row(path);
    return changed;
}

bool SceneForm::draw(std::string_view path, Field& field, double low, double high, double from) {
    const Label label = label_of(path);
    ImGui::PushID(path.data(), path.data() + path.size());
    const float width = ImGui::GetContentRegionAvail().x, reset_width = ImGui::GetFrameHeight();
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label.name.c_str());
    widgets::tip(std::string(field.rule.doc));
    ImGui::SameLine(width * 0.42f);
    ImGui::SetNextItemWidth(width * 0.58f - reset_width - ImGui::GetStyle().ItemSpacing.x);
    bool changed = false;
    const auto text_row = [&](const std::string& now) {
        const auto said = widgets::text_input("##v", now, kMaxText);
        if (!said || said->text == now)
            return;
        try {
            scene::set_field(m_scene, std::string(path), said->text);
            changed = true;
        } catch (const util::Error& e) {
            m_problem = e.what();
        }
    };
    // Offers the words of a field; @return the chosen one, if any.
    const auto choose = [&](std::string_view now) {
        std::optional<std::string_view> chosen;
        const auto shown = [](std::string_view word) {
            return word.empty() ? std::string("as the data say") : std::string(word);
        };
        if (!ImGui::BeginCombo("##v", shown(now).c_str()))
            return chosen;
        for (const std::string_view word : field.rule.words)
            if (ImGui::Selectable(shown(word).c_str(), word == now))
                chosen = word;
        ImGui::EndCombo();
        changed |= chosen.has_value();
        return chosen;
    };
    const auto maybe = [&](auto& value, auto first) {
        bool own = value.has_value();
        if (ImGui::Checkbox("##own", &own)) {
            if (own)
                value = first;
            else
                value.reset();
            changed = true;
        }
        widgets::tip(own ? "untick: as usual" : "tick: a value of its own");
        ImGui::SameLine();
        ImGui::SetNextItemWidth(std::max(
            ImGui::GetContentRegionAvail().x - reset_width - ImGui::GetStyle().ItemSpacing.x,
            20.0f));
        return value.has_value();
    };
    struct Drawing {
        const decltype(text_row)& text;
        const decltype(choose)& pick;
        const decltype(maybe)& own;
        const Field& field;
        double low, high, from;
        const Label& label;
        bool& changed;

        void operator()(double* v) const {
            changed |= number(*v, field.rule, low, high, label.unit);
        }
        void operator()(std::optional<double>* v) const {
            const double first =
                std::clamp(std::isfinite(from) ? from : 0.0, field.rule.min, field.rule.max);
            if (own(*v, std::isfinite(from) ? first
                                            : std::clamp(first, std::isfinite(low) ? low : first,
                                                         std::isfinite(high) ? high : first)))
                changed |= number(**v, field.rule, low, high, label.unit);
            else
                ImGui::TextDisabled("auto");
        }
        void operator()(int* v) const { changed |= whole_number(*v, field.rule, low, high); }
        void operator()(std::optional<int>* v) const {
            if (own(*v, static_cast<int>(low)))
                changed |= whole_number(**v, field.rule, low, high);
            else
                ImGui::TextDisabled("auto");
        }
        void operator()(bool* v) const { changed |= ImGui::Checkbox("##v", v); }
        void operator()(std::string* v) const {
            if (field.rule.words.empty())
                text(*v);
            else if (const auto word = pick(*v))
                *v = *word;
        }
        void operator()(std::optional<std::array<double, 3>>* v) const {
            if (own(*v, std::array<double, 3>{1, 1, 1})) {
                std::array<float, 3> c{static_cast<float>((**v)[0]), static_cast<float>((**v)[1]),
                                       static_cast<float>((**v)[2])};
                if (ImGui::ColorEdit3("##v", c.data(),
                                      ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR)) {
                    for (std::size_t i = 0; i < 3; ++i)
                        (**v)[i] =
                            std::clamp(static_cast<double>(c[i]), field.rule.min, field.rule.max);
                    changed = true;
                }
            } else
                ImGui::TextDisabled("auto");
        }
        void operator()(std::array<int, 2>* v) const {
            text(std::to_string((*v)[0]) + "x" + std::to_string((*v)[1]));
        }
        void operator()(scene::TileSize* v) const { text(v->text()); }
    };
    const Drawing drawing{text_row, choose, maybe, field, low, high, from, label, changed};
    std::visit(
        [&](auto* value) {
            using Held = std::remove_pointer_t<decltype(value)>;
            if constexpr (core::WordEnum<Held>) {
                if (const auto word = choose(core::word_of(*value)))
                    *value = core::from_word<Held>(*word).value_or(*value);
            } else {
                drawing(value);
            }
        },
        field.value);
    widgets::tell_place(std::string(path));
    const bool is_usual =
        std::visit([&](auto* value) { return *value == *std::get<decltype(value)>(field.usual); },
                   field.value);
    ImGui::SameLine(width - reset_width);
    if (widgets::reset_button(!is_usual)) {
        std::visit([&](auto* value) { *value = *std::get<decltype(value)>(field.usual); },
                   field.value);
        changed = true;
    }
    ImGui::PopID();
    return changed;
}

}  // namespace terravox::panels
