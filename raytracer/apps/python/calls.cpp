#include "raytracer/apps/python/calls.hpp"

#include <unistd.h>
#include <terravox/error.hpp>

namespace terravox::python {

namespace nb = nanobind;

namespace {

// They live as long as the interpreter.
PyObject* s_error = nullptr;
PyObject* s_usage_error = nullptr;

void translate(const std::exception_ptr& thrown, void* /*unused*/) {
    try {
        std::rethrow_exception(thrown);
    } catch (const UsageError& e) {
        PyErr_SetString(s_usage_error, e.what());
    } catch (const Error& e) {
        PyErr_SetString(s_error, e.what());
    }
}

PyObject* new_exception(const char* name, const char* about, const nb::object& bases) {
    PyObject* const made = PyErr_NewExceptionWithDoc(name, about, bases.ptr(), nullptr);
    if (made == nullptr)
        throw nb::python_error();
    return made;
}

}  // namespace

void add_errors(nb::module_& module) {
    s_error = new_exception("terravox.Error", "A request cannot be met; the message says why.",
                            nb::borrow(PyExc_RuntimeError));
    s_usage_error = new_exception(
        "terravox.UsageError", "The request is invalid; the message says what is allowed.",
        nb::make_tuple(nb::borrow(s_error), nb::borrow(PyExc_ValueError)));
    module.attr("Error") = nb::borrow(s_error);
    module.attr("UsageError") = nb::borrow(s_usage_error);
    nb::register_exception_translator(translate);
}

Calls& Calls::all() {
    static Calls calls;
    return calls;
}

Calls::Scope::Scope(const std::stop_source& stop) {
    Calls& calls = all();
    const std::lock_guard lock(calls.m_mutex);
    if (calls.m_closed)
        throw Error("use Terravox: the interpreter is about to end");
    calls.m_process = ::getpid();
    m_place = calls.m_running.insert(calls.m_running.end(), stop);
}

Calls::Scope::~Scope() {
    Calls& calls = all();
    const std::lock_guard lock(calls.m_mutex);
    calls.m_running.erase(m_place);
    calls.m_idle.notify_all();
}

void Calls::leave(std::thread thread, std::shared_future<void> ended) {
    const std::lock_guard lock(m_mutex);
    std::erase_if(m_left, [](LeftThread& left) {
        const bool is_over =
            left.ended.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
        if (is_over)
            left.thread.join();
        return is_over;
    });
    m_left.push_back({std::move(thread), std::move(ended)});
}

void Calls::finish() {
    std::unique_lock lock(m_mutex);
    m_closed = true;
    if (m_process != ::getpid()) {
        // They are another process's: what is left of them here can be neither joined nor
        // destroyed.
        if (!m_left.empty())
            m_others = new std::vector<LeftThread>(std::move(m_left));
        return;
    }
    for (std::stop_source& stop : m_running)
        stop.request_stop();
    m_idle.wait(lock, [this] { return m_running.empty(); });
    std::vector<LeftThread> left_threads = std::move(m_left);
    // These may need the interpreter's lock to end, which a thread may hold that waits for this
    // one.
    lock.unlock();
    for (LeftThread& left : left_threads)
        left.thread.join();
}

}  // namespace terravox::python
