#include "common/util/command_line.hpp"

#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <CLI/CLI.hpp>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/program.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"

namespace terravox::util {
namespace {

using Arguments = std::span<const char* const>;

constexpr std::string_view kFirstGroup = "Most used";
constexpr std::string_view kScenePrefix = "Scene: ";

/// The program and the subcommands that the parsing has reached, outermost first.
std::vector<const CLI::App*> reached_path(const CLI::App& app) {
    std::vector<const CLI::App*> out{&app};
    while (!out.back()->get_subcommands().empty())
        out.push_back(out.back()->get_subcommands().back());
    return out;
}

/// "terravox analyse sky"
std::string full_name(const std::vector<const CLI::App*>& path) {
    std::string out;
    for (const CLI::App* app : path)
        out += (out.empty() ? "" : " ") + app->get_name();
    return out;
}

/// For the beginning of a message: "analyse sky: "; "" of a program without subcommands.
std::string attempt(const std::vector<const CLI::App*>& path) {
    const std::string name = full_name({path.begin() + 1, path.end()});
    return name.empty() ? name : name + ": ";
}

std::vector<std::string> subcommand_names(const CLI::App& app) {
    std::vector<std::string> out;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        out.push_back(command->get_name());
    return out;
}

/// All that are listed, as they are typed.
std::vector<std::string> long_option_names(const CLI::App& app) {
    std::vector<std::string> out;
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty())
            for (const std::string& name : option->get_lnames())
                out.push_back("--" + name);
    return out;
}

std::vector<std::string> option_names(const CLI::Option& option) {
    std::vector<std::string> out;
    for (const std::string& name : option.get_snames())
        out.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        out.push_back("--" + name);
    return out;
}

/// "--size" of "--size=4x4".
std::string name_in(std::string_view argument) {
    return std::string(argument.substr(0, argument.find('=')));
}

/// The names by which an option stands on the command line; its usual one where it does not.
std::string typed_names(const CLI::Option& option, Arguments arguments) {
    const std::vector<std::string> names = option_names(option);
    std::vector<std::string> out;
    for (const std::string& name : names)
        if (std::any_of(arguments.begin(), arguments.end(), [&](const char* argument) {
                const std::string_view text = argument;
                // -ofile.png is the short option with its value.
                const bool has_value = name.size() == 2 && text.starts_with(name);
                return has_value || name_in(text) == name;
            }))
            out.push_back(name);
    return out.empty() ? option.get_name() : comma_list(out);
}

bool is_long_option(std::string_view argument) {
    return argument.size() > 2 && argument.starts_with("--");
}

// Help.

bool has_first_group(const CLI::App& app) {
    const std::vector<std::string> groups = app.get_groups();
    return std::find(groups.begin(), groups.end(), kFirstGroup) != groups.end();
}

std::size_t count_in_group(const CLI::App& app, const std::string& group) {
    return app
        .get_options([&](const CLI::Option* option) {
            return option->get_group() == group && option->nonpositional();
        })
        .size();
}

/// The word that chooses a group: "camera" of "Scene: camera".
std::string group_word(std::string_view group) {
    return lower_case(group.starts_with(kScenePrefix) ? group.substr(kScenePrefix.size()) : group);
}

/// Groups of options behind the first one.
std::vector<std::string> other_groups(const CLI::App& app) {
    std::vector<std::string> out = app.get_groups();
    std::erase_if(out, [&](const std::string& group) {
        return group.empty() || group == kFirstGroup || count_in_group(app, group) == 0;
    });
    return out;
}

std::string choices_text(const CLI::App& app) {
    std::vector<std::string> words;
    for (const std::string& group : other_groups(app))
        words.push_back(group_word(group) + " (" + std::to_string(count_in_group(app, group)) +
                        ")");
    return "\nFurther options, with --help GROUP or --help all: " + comma_list(words) + "\n";
}

class HelpFormatter : public CLI::Formatter {
public:
    [[nodiscard]] std::string first_options(const CLI::App& app, const std::string& name) const {
        return make_description(&app) + make_usage(&app, name) + make_positionals(&app) +
               group(app, std::string(kFirstGroup)) + choices_text(app);
    }
    [[nodiscard]] std::string group(const CLI::App& app, const std::string& group) const {
        return make_group(group, false, app.get_options([&](const CLI::Option* option) {
            return option->get_group() == group && option->nonpositional();
        }));
    }
};

/// The word after --help or -h.
std::optional<std::string> help_topic(Arguments arguments) {
    for (std::size_t i = 0; i + 1 < arguments.size(); ++i) {
        const std::string_view option = arguments[i];
        if ((option == "--help" || option == "-h") && arguments[i + 1][0] != '-')
            return arguments[i + 1];
    }
    return std::nullopt;
}

// Refusals.

/// An argument that no option and no command takes.
struct Unknown {
    const CLI::App* app;  ///< the command that it was read by
    std::string text;
};

/// The first of the innermost command, or of one around it, that is an option or that is none.
std::optional<Unknown> first_unknown(const std::vector<const CLI::App*>& path, bool is_option) {
    for (auto app = path.rbegin(); app != path.rend(); ++app) {
        // These take the arguments of another program.
        if ((*app)->get_allow_extras() || (*app)->get_prefix_command())
            continue;
        for (const std::string& text : (*app)->remaining())
            if (text.starts_with('-') == is_option)
                return Unknown{*app, text};
    }
    return std::nullopt;
}

/// Words are often the values of an unknown option; but where a command is missing, one of them is
/// meant to be it.
std::optional<Unknown> first_unknown(const std::vector<const CLI::App*>& path) {
    const bool is_command_missing = !subcommand_names(*path.back()).empty();
    const auto found = first_unknown(path, !is_command_missing);
    return found ? found : first_unknown(path, is_command_missing);
}

std::string describe_unknown(const std::vector<const CLI::App*>& path, const Unknown& unknown) {
    const CLI::App& command = *path.back();
    const std::string name = name_in(unknown.text);
    if (unknown.text.starts_with('-')) {
        const std::vector<std::string> known = long_option_names(command);
        if (unknown.app != &command && command.get_option_no_throw(name) != nullptr)
            return attempt(path) + "the option " + name +
                   " stands before the command; allowed: " + "behind it";
        const std::string meant = did_you_mean(name, known);
        return attempt(path) + "unknown option " + name +
               (meant.empty() ? std::string("; --help") + (has_first_group(command) ? " all" : "") +
                                    " lists every option"
                              : meant);
    }
    const std::vector<std::string> commands = subcommand_names(command);
    if (commands.empty())
        return attempt(path) + "unexpected argument '" + unknown.text +
               "'; --help shows what is allowed";
    return attempt(path) + "unknown command '" + unknown.text + "'" +
           allowed_words(unknown.text, commands);
}

/// The first required argument that is not there, or else the first such option.
const CLI::Option* first_missing(const std::vector<const CLI::App*>& path) {
    const CLI::Option* found = nullptr;
    for (const CLI::App* app : path)
        for (const CLI::Option* option : app->get_options()) {
            if (!option->get_required() || option->count() > 0)
                continue;
            if (option->get_positional())
                return option;
            if (found == nullptr)
                found = option;
        }
    return found;
}

std::string describe_missing(const std::vector<const CLI::App*>& path, const CLI::Option& option) {
    const std::string text = option.get_description();
    const std::string name = option.get_positional() ? option.get_name(true) : option.get_name();
    return attempt(path) + name +
           (option.get_items_expected_max() > 1 && option.get_positional() ? " are" : " is") +
           " missing" + (text.empty() ? "" : ": " + text);
}

/// The option that an error is about: messages of the library name it.
const CLI::Option* option_in(const std::vector<const CLI::App*>& path, std::string_view message) {
    const CLI::Option* found = nullptr;
    for (const CLI::App* app : path)
        for (const CLI::Option* option : app->get_options()) {
            const std::string name = option->get_name();
            // "--size" is also the beginning of others.
            const bool is_longer = found == nullptr || name.size() > found->get_name().size();
            if (is_longer && message.find(name) != std::string_view::npos)
                found = option;
        }
    return found;
}

bool is(const CLI::ParseError& error, CLI::ExitCodes code) {
    return error.get_exit_code() == static_cast<int>(code);
}

/// Two options that exclude each other, where both are given.
std::optional<std::string> describe_excluded(const std::vector<const CLI::App*>& path,
                                             Arguments arguments) {
    for (const CLI::App* app : path)
        for (const CLI::Option* option : app->get_options())
            for (const CLI::Option* other : option->get_excludes())
                if (option->count() > 0 && other->count() > 0)
                    return typed_names(*option, arguments) + " and " +
                           typed_names(*other, arguments) + " are given; allowed: one of them";
    return std::nullopt;
}

/// What a value has to be, by the name of its type in the help.
std::string allowed_by_type(const std::string& type) {
    if (type.starts_with("INT"))
        return "a whole number";
    if (type.starts_with("UINT"))
        return "a whole number, 0 or more";
    return type.starts_with("FLOAT") ? "a number" : "";
}

/// "0 to 20" of a message of the library, whose versions write "not in range 0 to 20" or "[0 -
/// 20]".
std::optional<std::string> find_range(std::string_view message) {
    constexpr std::string_view kBefore = " not in range ";
    const std::size_t at = message.find(kBefore);
    if (at == std::string_view::npos)
        return std::nullopt;
    std::string out(message.substr(at + kBefore.size()));
    std::erase_if(out, [](char c) { return c == '[' || c == ']'; });
    constexpr std::string_view kTo = " - ";
    if (const std::size_t to = out.find(kTo); to != std::string::npos)
        out.replace(to, kTo.size(), " to ");
    return out;
}

/// What is wrong with a value, by the library's check of it.
std::string describe_refused(const std::string& value, const CLI::Option& option,
                             const CLI::ParseError& error) {
    const std::vector<std::string> words = find_value_words(option);
    if (!words.empty())
        return " = '" + value + "'" + allowed_words(value, words);
    if (const auto range = find_range(error.what()))
        return " = '" + value + "'; allowed: " + *range;
    const std::string type = allowed_by_type(option.get_type_name());
    return type.empty() ? "" : " = '" + value + "'; allowed: " + type;
}

/// The message of the library with the option as it was typed, and what its values are.
std::string describe_value(const CLI::Option& option, const CLI::ParseError& error,
                           Arguments arguments) {
    const std::string typed =
        option.get_positional() ? option.get_name(true) : typed_names(option, arguments);
    const std::vector<std::string>& values = option.results();
    if (option.get_items_expected_max() == 1 && values.size() > 1)
        return typed + ": given " + std::to_string(values.size()) + " times; allowed: once";
    if (is(error, CLI::ExitCodes::ArgumentMismatch) && values.empty())
        return typed + ": its value is missing: " + option.get_description();
    const bool is_of_value =
        is(error, CLI::ExitCodes::ValidationError) || is(error, CLI::ExitCodes::ConversionError);
    if (is_of_value && !values.empty())
        if (const std::string what = describe_refused(values.back(), option, error); !what.empty())
            return typed + what;
    std::string out = error.what();
    return out.replace(out.find(option.get_name()), option.get_name().size(), typed);
}

}  // namespace

void list_first(CLI::App& command, std::initializer_list<const char*> names) {
    command.get_help_ptr()
        ->description("print this; --help all: every option; --help GROUP: those of a group")
        ->group(std::string(kFirstGroup));
    for (const char* name : names)
        command.get_option(name)->group(std::string(kFirstGroup));
}

std::string help_text(const CLI::App& app, Arguments arguments) {
    const std::vector<const CLI::App*> path = reached_path(app);
    const CLI::App& command = *path.back();
    const HelpFormatter formatter;
    const std::string all =
        formatter.make_help(&command, full_name(path), CLI::AppFormatMode::Normal);
    if (!has_first_group(command))
        return all;
    const std::optional<std::string> topic = help_topic(arguments);
    if (!topic)
        return formatter.first_options(command, full_name(path));
    if (*topic == "all")
        return all;
    std::vector<std::string> words{"all"};
    for (const std::string& group : other_groups(command)) {
        words.push_back(group_word(group));
        if (words.back() == lower_case(*topic))
            return formatter.group(command, group).substr(1);
    }
    throw UsageError("{}--help {}{}", attempt(path), *topic, allowed_words(*topic, words));
}

void refuse_removed_option(CLI::App& command, const std::string& name, const std::string& instead) {
    command
        .add_flag_callback(
            name,
            [name, instead] { throw UsageError("{} was removed; allowed: {}", name, instead); })
        ->trigger_on_parse()
        ->group("");
}

void refuse_misread_arguments(const CLI::App& app, Arguments arguments) {
    std::vector<const CLI::App*> path{&app};
    const CLI::Option* takes_next = nullptr;  ///< the option before, where it has no value yet
    for (const char* const argument : arguments) {
        const std::string text = argument;
        if (text == "--")
            return;
        const CLI::Option* named = is_long_option(text) || (text.size() == 2 && text[0] == '-')
                                       ? path.back()->get_option_no_throw(name_in(text))
                                       : nullptr;
        if (takes_next != nullptr && is_long_option(text) && named != nullptr)
            throw UsageError("{}{}: its value is missing, {} follows; allowed: {}", attempt(path),
                             typed_names(*takes_next, arguments), name_in(text),
                             takes_next->get_description());
        const bool has_one_hyphen = text.size() > 2 && text[0] == '-' && text[1] != '-';
        if (has_one_hyphen && takes_next == nullptr &&
            path.back()->get_option_no_throw("-" + name_in(text)) != nullptr)
            throw UsageError("{}unknown option {}; did you mean -{}?", attempt(path), name_in(text),
                             name_in(text));
        const bool was_value = takes_next != nullptr;
        const bool has_own_value = text.find('=') != std::string::npos;
        takes_next = named != nullptr && !has_own_value && named->get_items_expected_min() > 0
                         ? named
                         : nullptr;
        if (named != nullptr || was_value)
            continue;
        const auto inner = path.back()->get_subcommands(
            [&](const CLI::App* command) { return command->get_name() == text; });
        if (!inner.empty())
            path.push_back(inner.front());
    }
}

std::string usage_message(const CLI::App& app, const CLI::ParseError& error, Arguments arguments) {
    const std::vector<const CLI::App*> path = reached_path(app);
    if (is(error, CLI::ExitCodes::RequiredError) || is(error, CLI::ExitCodes::ExtrasError)) {
        if (const auto unknown = first_unknown(path))
            return describe_unknown(path, *unknown);
        if (const CLI::Option* const missing = first_missing(path))
            return describe_missing(path, *missing);
        const std::vector<std::string> commands = subcommand_names(*path.back());
        if (!commands.empty())
            return attempt(path) + "a command is missing; allowed: " + comma_list(commands);
    }
    if (is(error, CLI::ExitCodes::ExcludesError))
        if (const auto excluded = describe_excluded(path, arguments))
            return attempt(path) + *excluded;
    if (const CLI::Option* const option = option_in(path, error.what()))
        return attempt(path) + describe_value(*option, error, arguments);
    return attempt(path) + error.what() + "; --help lists what is allowed";
}

int run_command_program(const CommandWithProgram& command, int argc, char** argv,
                        const AddOptions& add_options) {
    return run_program([&] {
        CLI::App app{command.description, std::string(command.listed_by) + " " + command.name};
        app.set_version_flag("--version", std::string("terravox ") + kVersion);
        const auto run = add_options(app);
        if (const auto answered = parse_arguments(app, argc, argv))
            return *answered;
        return static_cast<int>(run());
    });
}

void list_command(CLI::App& app, const CommandWithProgram& command) {
    app.add_subcommand(command.name, command.description);
}

void go_on_as(const CommandWithProgram& command, int argc, char** argv) {
    if (argc < 2 || std::string_view(argv[1]) != command.name)
        return;
    std::string program = beside_program(command.program).string();
    argv[1] = program.data();
    ::execv(program.c_str(), argv + 1);
    throw Error("run {}: cannot start {}: {}; it belongs in the folder of this program",
                command.name, program, std::strerror(errno));
}

}  // namespace terravox::util
