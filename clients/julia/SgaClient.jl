# A client of sgad for Julia 1.6 and newer, by the standard library's Downloads and the package JSON.
#
# No Julia was at hand when it was written: it has not been run. It is small so that it can be read; what it asks of the service is held against
# the service's description by a test.
module SgaClient

using Downloads
using JSON

export Client, SgaError, solve, submit, wait_for, cancel, check, samples, column, code, model

"How many seconds one request waits for a job; the next one goes on waiting."
const POLL = 20

"""
    Client(url; token)

A service at `http://HOST:PORT` or `https://HOST:PORT`; `SGA_SERVER` and `SGA_TOKEN` say what is not given. Certificates that are trusted are
those of `JULIA_SSL_CA_ROOTS_PATH`, else the system's.
"""
struct Client
    url::String
    token::String
end

function Client(url::AbstractString = get(ENV, "SGA_SERVER", "http://127.0.0.1:8080"); token::AbstractString = get(ENV, "SGA_TOKEN", ""))
    return Client(String(rstrip(url, '/')), String(token))
end

Base.show(io::IO, client::Client) = print(io, "SgaClient.Client(", repr(client.url), ")")

"""
What the service said is wrong: `code` does not change between versions, `detail` is for people, `pointer` says where in the request; `problem` is
the whole object, `status` that of HTTP, 0 where a job failed.
"""
struct SgaError <: Exception
    code::String
    detail::String
    pointer::String
    status::Int
    problem::Dict{String,Any}
end

function SgaError(problem::Dict{String,Any}, status::Integer)
    text(key) = string(something(get(problem, key, nothing), ""))
    return SgaError(text("code"), isempty(text("detail")) ? text("title") : text("detail"), text("pointer"), Int(status), problem)
end

function Base.showerror(io::IO, e::SgaError)
    print(io, "SgaError: ", e.detail, " (", e.code)
    isempty(e.pointer) || print(io, " at ", e.pointer)
    haskey(e.problem, "column") && print(io, ", line ", get(e.problem, "line", 1), ", column ", e.problem["column"])
    print(io, ")")
end

"A job was waited for no longer; it runs on unless it is cancelled."
struct Late <: Exception
    job::String
end

read_json(text::AbstractString) = JSON.parse(text; dicttype = Dict{String,Any})

"The problem in a reply; what is none becomes one."
function problem_of(text::AbstractString, status::Integer)
    try
        problem = read_json(text)
        problem isa Dict{String,Any} && return problem
    catch
    end
    return Dict{String,Any}("code" => "http_$(status)", "detail" => "the service answered with status $(status)")
end

"The text of a reply. SgaError where its status says so; Downloads.RequestError where there is none."
function ask(client::Client, method::String, path::String, body::Union{Nothing,String} = nothing; wait::Integer = 0)
    headers = Pair{String,String}[]
    isempty(client.token) || push!(headers, "Authorization" => "Bearer " * client.token)
    wait > 0 && push!(headers, "Prefer" => "wait=$(wait)")
    output = IOBuffer()
    if body === nothing
        response = Downloads.request(client.url * path; method = method, headers = headers, output = output, timeout = wait + 60)
    else
        push!(headers, "Content-Type" => "application/json")
        response = Downloads.request(client.url * path; method = method, headers = headers, input = IOBuffer(body), output = output, timeout = wait + 60)
    end
    text = String(take!(output))
    200 <= response.status < 300 && return text
    throw(SgaError(problem_of(text, response.status), response.status))
end

json_of(request::AbstractString) = String(request)

"What stands for many entries is not written out here: lists come whole, unless the request says otherwise."
function json_of(request)
    whole = Dict{String,Any}("families" => "whole")
    for (key, value) in pairs(request)
        whole[string(key)] = value
    end
    return JSON.json(whole)
end

"""
    submit(client, request)

The id of a job for the request, a dictionary or JSON as text.
"""
submit(client::Client, request) = String(read_json(ask(client, "POST", "/v1/jobs", json_of(request)))["id"])

"""
    wait_for(client, id; timeout = Inf)

The answer of a job, once it is there. SgaError where the job failed, Late after so many seconds: then it runs on.
"""
function wait_for(client::Client, id::AbstractString; timeout::Real = Inf)
    until = time() + timeout
    while true
        left = until - time()
        left <= 0 && throw(Late(String(id)))
        job = read_json(ask(client, "GET", "/v1/jobs/" * id; wait = max(1, floor(Int, min(POLL, left)))))
        status = job["status"]
        status == "done" && haskey(job, "result") && return job["result"]
        if status == "failed" || status == "cancelled"
            error = get(job, "error", nothing)
            problem = error isa Dict{String,Any} ? error : Dict{String,Any}("code" => String(status), "detail" => "the job was $(status)")
            throw(SgaError(problem, 0))
        end
    end
end

"""
    solve(client, request; timeout = Inf)

The answer. A job that is waited for no longer is cancelled.
"""
function solve(client::Client, request; timeout::Real = Inf)
    id = submit(client, request)
    try
        return wait_for(client, id; timeout = timeout)
    catch e
        (e isa InterruptException || e isa Late) && cancel(client, id)
        rethrow()
    end
end

"Withdraws: a job that nobody else wants is stopped; one that has ended leaves the list."
function cancel(client::Client, id::AbstractString)
    ask(client, "DELETE", "/v1/jobs/" * id)
    return nothing
end

"All that there is to say of a request without running it: `valid`, `problems`, `warnings`, ..."
check(client::Client, request) = read_json(ask(client, "POST", "/v1/check", json_of(request)))

"""
    samples(result)

`(columns, values)` of the trajectory of an answer: names, and a matrix with a row for each sample, NaN where there is no value.
"""
function samples(result::AbstractDict)
    trajectory = result["trajectory"]
    columns = String[string(name) for name in trajectory["columns"]]
    rows = trajectory["rows"]
    values = fill(NaN, length(rows), length(columns))
    for (i, row) in enumerate(rows), (j, value) in enumerate(row)
        value === nothing || (values[i, j] = Float64(value))
    end
    return columns, values
end

"One column of the samples, by its name."
function column(result::AbstractDict, name::AbstractString)
    columns, values = samples(result)
    j = findfirst(==(name), columns)
    j === nothing && throw(KeyError(name))
    return values[:, j]
end

"""
    code(client, id, language = "julia")

A finished answer as source: constraints, reduced field, gauge fields, Jacobian and a projection.
"""
code(client::Client, id::AbstractString, language::AbstractString = "julia") = ask(client, "GET", "/v1/jobs/" * id * "/code?language=" * language)

"""
    model(client, id)

The module `SgaModel` of a finished answer, with its functions `field`, `constraints`, `jacobian`, `gauge_fields` and `project`. Inside of a function that
called `model`, call them by `Base.invokelatest`.
"""
function model(client::Client, id::AbstractString)
    holder = Module(:SgaHolder)
    include_string(holder, code(client, id))
    return Base.invokelatest(getfield, holder, :SgaModel)
end

end # module
